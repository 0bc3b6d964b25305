// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "bytes_file.hpp"
#include "waymark/base/time.hpp"

namespace waymark::radar {

/// Rows of comma-separated text whose first row names the columns.
class TextTable {
 public:
  /// Finds `columns`. Throws DataError if one of them is missing.
  TextTable(std::unique_ptr<BytesFile> file, std::vector<std::string_view> columns);

  /// Reads the next row; false at the end. Throws DataError if it is too short.
  bool next();
  /// Of the last row, by the position in `columns`. Both throw DataError for what is none.
  double number(std::size_t column) const;
  Time time(std::size_t column) const;

  std::string place() const { return file_->name() + ":" + std::to_string(row_); }  ///< "file:line"
  double progress() const { return file_->progress(); }

 private:
  void split();

  std::unique_ptr<BytesFile> file_;
  std::vector<std::string_view> columns_;
  std::vector<std::size_t> at_;
  std::string text_;
  std::vector<std::string_view> fields_;
  std::size_t row_ = 0;  // of the file, from 1
};

}  // namespace waymark::radar
