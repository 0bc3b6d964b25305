// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "waymark/base/time.hpp"

namespace waymark::evaluation {

/// Which column (from 0) holds which quantity: {"t": 0, "x": 1, "y": 2}.
using Columns = std::map<std::string, int, std::less<>>;

/// Reads `t=0,x=1,y=2`. Throws Error if it has another shape, names a quantity that is not in `allowed`, or one twice.
Columns parse_columns(std::string_view text, const std::vector<std::string>& allowed);

/// The rows of a text file. Fields are separated by commas, semicolons or blanks, whichever the first row uses; empty
/// lines and lines that start with `#` are skipped. Files compressed with gzip are read as they are.
class Table {
 public:
  /// Throws DataError if the file cannot be read or holds no row.
  explicit Table(const std::filesystem::path& file);

  std::size_t rows() const { return rows_.size(); }
  int width() const { return static_cast<int>(rows_.front().fields.size()); }
  /// True if the fields are separated by blanks.
  bool blank_separated() const { return separator_ == ' '; }
  /// True if no field of the first row is a number, or one of them is not a number and `names` has it: then it names
  /// the columns.
  bool starts_with_names(const std::vector<std::string_view>& names) const;
  /// Drops the first row; throws DataError if nothing is left.
  void drop_first_row();

  /// The field, without blanks around it. Throws DataError with file and line if the row is too short.
  const std::string& field(std::size_t row, int column) const;
  /// The field as a finite number. Throws DataError with file, line and `name`.
  double number(std::size_t row, int column, std::string_view name) const;
  /// The field, decimal seconds, as a stamp. Throws DataError with file, line and `name`.
  Time time(std::size_t row, int column, std::string_view name = "time") const;
  /// The field as a number, or NaN if it is empty, no finite number, or missing in a short row.
  double number_or_nan(std::size_t row, int column) const;
  /// "file:line" of a row.
  std::string place(std::size_t row) const;
  const std::filesystem::path& file() const { return file_; }

 private:
  struct Row {
    std::size_t line;
    std::vector<std::string> fields;
  };

  std::filesystem::path file_;
  char separator_ = ' ';
  std::vector<Row> rows_;
};

}  // namespace waymark::evaluation
