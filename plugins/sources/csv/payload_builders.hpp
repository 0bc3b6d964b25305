// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "column_map.hpp"
#include "waymark/config.hpp"
#include "waymark/measurement.hpp"

namespace waymark::csv {

/// Turns rows into payloads of one type.
class PayloadBuilder {
 public:
  virtual ~PayloadBuilder() = default;

  /// A payload out of one row. Throws BadRow.
  virtual std::shared_ptr<Payload> build(Row row) const = 0;
  /// Adds one row to what `build` made, if rows can form a set. Throws BadRow, and leaves the payload alone then.
  virtual void append(Row row, Payload& payload) const;
  virtual bool can_append() const { return false; }
  /// True if every row must have as many fields as the file's first.
  virtual bool wants_equal_rows() const { return false; }
};

/// The full type of a name in the YAML: "LaserScan" or "waymark/LaserScan@1". Throws ConfigError at `payload` of the
/// entry.
std::string_view payload_type(const Config& entry);

/// The builder for that type from `columns` (and `scan`) of the entry. Throws ConfigError.
std::unique_ptr<PayloadBuilder> make_payload_builder(std::string_view type, const Config& entry, ColumnFinder& finder);

}  // namespace waymark::csv
