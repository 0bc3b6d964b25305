// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "delimited_reader.hpp"
#include "units.hpp"
#include "waymark/config/config.hpp"

namespace waymark::csv {

/// One column of a file.
struct Column {
  std::size_t index = 0;
  std::string label;  ///< for messages: `column "v" (speed_mps)`
};

/// Finds the columns that the YAML names, by 0-based number or header name, and keeps account of them.
class ColumnFinder {
 public:
  explicit ColumnFinder(std::vector<std::string> header)
      : header_(std::make_shared<const std::vector<std::string>>(std::move(header))) {}

  /// The column that scalar `key` of `config` names, for the payload field `field`. Throws ConfigError (no such name).
  Column find(const Config& config, const Config::Key& key, std::string_view field);
  /// The same for a column whose name was read already.
  Column find(const Config& config, std::string_view key, const std::string& name, std::string_view field);
  /// Counts `count` columns from `first` as used by `field`.
  void use(std::size_t first, std::size_t count, std::string_view field);
  /// Counts what else tells two entries on the same columns apart.
  void note(std::string what);

  /// The names of the columns; empty if the file has none.
  std::shared_ptr<const std::vector<std::string>> header() const { return header_; }

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
  std::shared_ptr<const std::vector<std::string>> header_;
  std::size_t needed_ = 0;
  std::vector<std::string> used_;
  bool allows_empty_ = false;
  bool keeps_invalid_ = false;
};

/// A number: raw · scale + offset in the unit that the YAML names, converted to the field's; or the same in all rows.
class NumberColumn {
 public:
  /// Reads the field `key` of `columns`, in any unit of its kind: a column, {column, scale, offset, unit}, or
  /// {constant} instead of a column. Throws ConfigError.
  NumberColumn(const Config& columns, const Config::Key& key, ColumnFinder& finder);

  /// Throws BadRow if the field is not a finite number. NaN if it is unknown.
  double read(Row row) const;
  /// NaN and infinity are values, too. Throws BadRow if the field is no number.
  double read_any(Row row) const;
  /// Throws BadRow if the value is not a whole number within int. Not to be asked for an unknown one.
  int read_integer(Row row) const;
  /// True if the field is empty and may be.
  bool is_unknown(Row row) const { return may_be_empty_ && is_empty(row); }
  bool is_empty(Row row) const { return !constant_ && row[column_.index].empty(); }
  void allow_empty() {
    may_be_empty_ = true;
    is_plain_ = false;
  }
  /// The value of all rows, if there is no column.
  std::optional<double> constant() const { return constant_; }
  /// For messages: where the value comes from, and what stands there.
  const std::string& label() const { return column_.label; }
  std::string text(Row row) const;
  /// From `before` to `after`, two values of `read`. If raw numbers start over at `wraps_at` (0: they do not), it is
  /// less than half of that.
  double growth(double before, double after, double wraps_at) const;

 private:
  Column column_;
  bool may_be_empty_ = false;
  bool is_plain_ = true;  // always a column with a number in it
  double scale_ = 1.0;    // with the unit's factor, as the offset
  double offset_ = 0.0;
  std::optional<double> constant_;
};

/// Reads `key` if it is there; its fields may be empty if the finder allows that.
std::optional<NumberColumn> optional_number_column(const Config& columns, const Config::Key& key, ColumnFinder& finder);

/// Neighbouring columns that form one list.
class ColumnRange {
 public:
  /// Reads the field `key` of `columns`, in any unit of its kind: {first, count or last, scale, offset, unit}. Throws
  /// ConfigError.
  ColumnRange(const Config& columns, const Config::Key& key, ColumnFinder& finder);

  std::size_t count() const { return count_; }
  /// Fills `values` with `count()` numbers. A field that is not finite is a BadRow, or becomes `non_finite` if that is
  /// given.
  void read(Row row, std::vector<float>& values, std::optional<float> non_finite) const;

 private:
  std::string label(std::size_t beam) const;

  std::string field_;
  std::shared_ptr<const std::vector<std::string>> header_;
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  double scale_ = 1.0;
  double offset_ = 0.0;
};

/// Throws ConfigError for a key of `columns` that is not in `valid`, with the nearest valid one, and for a missing key
/// of `required`.
void check_fields(const Config& columns, const std::vector<FieldName>& valid,
                  const std::vector<std::string_view>& required, std::string_view owner);

/// "; did you mean "x"? (valid: x, y)", for messages about a name that is not in `names`.
std::string suggestion(std::string_view name, const std::vector<std::string_view>& names);

/// The file that `path` names. Throws ConfigError if it cannot be read.
std::filesystem::path text_file(const Config& config);

/// The key `empty_is_unknown`.
bool empty_is_unknown(const Config& config);

/// The keys `delimiter`, `comment` and `header_rows`, or `records`. Throws ConfigError.
Format read_format(const Config& config);

}  // namespace waymark::csv
