// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "delimited_reader.hpp"
#include "waymark/base/time.hpp"
#include "waymark/config/config.hpp"

namespace waymark::csv {

/// Why a row cannot be used. Caught where rows are read; never leaves the plugin.
class BadRow : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// One column of a file.
struct Column {
  std::size_t index = 0;
  std::string label;  ///< for messages: `column 2 (speed_mps)`
};

/// Finds the columns that the YAML names, by 0-based number or header name, and keeps account of them.
class ColumnFinder {
 public:
  explicit ColumnFinder(std::vector<std::string> header) : header_(std::move(header)) {}

  /// The column that scalar `key` of `config` names, for the payload field `field`. Throws ConfigError (no such name).
  Column find(const Config& config, const Config::Key& key, std::string_view field);
  /// The same for a column whose name was read already.
  Column find(const Config& config, std::string_view key, const std::string& name, std::string_view field);
  /// Counts `count` columns from `first` as used by `field`.
  void use(std::size_t first, std::size_t count, std::string_view field);

  /// A row with fewer fields is a bad row.
  std::size_t needed_fields() const { return needed_; }
  /// Equal for two entries that read the same fields from the same columns.
  std::string signature() const;

  /// From now on an empty field of an optional column is an unknown value, not a fault.
  void allow_empty() { allows_empty_ = true; }
  bool allows_empty() const { return allows_empty_; }
  /// Values that break a rule of the payload are none either; an empty field of a required column is NaN then.
  void keep_invalid() { keeps_invalid_ = true; }
  bool keeps_invalid() const { return keeps_invalid_; }

 private:
  std::vector<std::string> header_;
  std::size_t needed_ = 0;
  std::vector<std::string> used_;
  bool allows_empty_ = false;
  bool keeps_invalid_ = false;
};

/// A number: raw · scale + offset.
class NumberColumn {
 public:
  /// Reads `key` of `columns`: a column, or {column, scale, offset}. Throws ConfigError.
  NumberColumn(const Config& columns, const Config::Key& key, ColumnFinder& finder);

  /// Throws BadRow if the field is not a finite number. NaN if it is unknown.
  double read(Row row) const;
  /// Throws BadRow if the value is not a whole number within int. Not to be asked for an unknown one.
  int read_integer(Row row) const;
  /// True if the field is empty and may be.
  bool is_unknown(Row row) const { return may_be_empty_ && row[column_.index].empty(); }
  void allow_empty() { may_be_empty_ = true; }
  const Column& column() const { return column_; }
  /// From `before` to `after`, two values of `read`. If raw numbers start over at `wraps_at` (0: they do not), it is
  /// less than half of that.
  double growth(double before, double after, double wraps_at) const;

 private:
  Column column_;
  bool may_be_empty_ = false;
  double scale_ = 1.0;
  double offset_ = 0.0;
};

/// Reads `key` if it is there; its fields may be empty if the finder allows that.
std::optional<NumberColumn> optional_number_column(const Config& columns, const Config::Key& key, ColumnFinder& finder);

/// Neighbouring columns that form one list.
class ColumnRange {
 public:
  /// Reads `key` of `columns`: {first, count or last, scale, offset}. Throws ConfigError.
  ColumnRange(const Config& columns, const Config::Key& key, ColumnFinder& finder);

  std::size_t count() const { return count_; }
  /// Fills `values` with `count()` numbers. A field that is not finite is a BadRow, or becomes `non_finite` if that is
  /// given.
  void read(Row row, std::vector<float>& values, std::optional<float> non_finite) const;

 private:
  std::string label(std::size_t beam) const;

  std::string field_;
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  double scale_ = 1.0;
  double offset_ = 0.0;
};

/// A stamp. Decimal digits reach int64 nanoseconds exactly if the scale is a power of ten.
class TimeColumn {
 public:
  /// Reads `key`: a column in seconds, or {column, scale, offset_s}. Throws ConfigError.
  TimeColumn(const Config& config, const Config::Key& key, ColumnFinder& finder);

  /// Throws BadRow if the field is not a time.
  Time read(Row row) const;

 private:
  Column column_;
  std::optional<int> exponent_;  // of the scale, if that is a power of ten
  double scale_ = 1.0;
  std::int64_t offset_ns_ = 0;
};

/// Keeps the rows that satisfy all conditions of the list `where`.
class RowFilter {
 public:
  /// Throws ConfigError.
  RowFilter(const Config& config, ColumnFinder& finder);

  /// Throws BadRow if a field is not a finite number.
  bool keeps(Row row) const;
  /// Equal for equal conditions.
  const std::string& signature() const { return signature_; }

 private:
  struct Condition {
    Column column;
    std::optional<std::vector<double>> in;
    std::vector<double> not_in;
    double min = -std::numeric_limits<double>::infinity();
    double max = std::numeric_limits<double>::infinity();
  };

  std::vector<Condition> conditions_;
  std::string signature_;
};

/// Throws ConfigError for a key of `columns` that is not in `valid`, with the nearest valid one, and for a missing key
/// of `required`.
void check_fields(const Config& columns, const std::vector<std::string_view>& valid,
                  const std::vector<std::string_view>& required, std::string_view owner);

/// "; did you mean "x"? (valid: x, y)", for messages about a name that is not in `names`.
std::string suggestion(std::string_view name, const std::vector<std::string_view>& names);

/// The file that `path` names. Throws ConfigError if it cannot be read.
std::filesystem::path text_file(const Config& config);

/// The key `empty_is_unknown`.
bool empty_is_unknown(const Config& config);

/// The keys `delimiter`, `comment` and `header_rows`. Throws ConfigError.
Format read_format(const Config& config);

}  // namespace waymark::csv
