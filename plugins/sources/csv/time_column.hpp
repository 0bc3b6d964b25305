// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "column_map.hpp"
#include "number_text.hpp"
#include "waymark/base/time.hpp"

namespace waymark::csv {

/// A stamp: a number, or a date and time of ISO 8601. Decimal digits reach int64 nanoseconds exactly if the scale is a
/// power of ten.
class TimeColumn {
 public:
  /// Reads `key`, or the same with the suffix of a unit (`time_ms`): a column, or {column, unit or scale, offset_s}.
  /// Throws ConfigError.
  TimeColumn(const Config& config, const Config::Key& key, ColumnFinder& finder);

  /// Throws BadRow if the field is not a time.
  Time read(Row row) const;

 private:
  std::int64_t nanoseconds(std::string_view field) const;
  void refuse_seconds(std::string_view field) const;
  [[noreturn]] void reject_time(std::string_view field, NumberText text) const;

  Column column_;
  std::optional<int> exponent_ = 0;  // of the scale, if that is a power of ten
  double scale_ = 1.0;
  bool is_plain_ = true;  // neither unit nor scale is given
  std::int64_t offset_ns_ = 0;
};

}  // namespace waymark::csv
