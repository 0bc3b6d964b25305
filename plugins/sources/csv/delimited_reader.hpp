// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "plugins/shared/compression/byte_stream.hpp"
#include "record_reader.hpp"

namespace waymark::csv {

/// The fields of one row, without surrounding blanks and quotes.
using Row = std::span<const std::string_view>;

/// How a file is laid out; what is absent of a text file is guessed from its first rows.
struct Format {
  static constexpr char kBlanks = ' ';  ///< as delimiter: a run of spaces and tabs

  std::optional<char> delimiter;
  std::string comment = "#";  ///< lines that start with it are skipped; empty: there are none
  std::optional<int> header_rows;
  std::optional<RecordLayout> records;  ///< the file is binary
};

/// The lines of a text file, plain or gzip, with a bounded buffer.
class LineReader {
 public:
  /// Throws DataError if the file cannot be opened.
  LineReader(const std::filesystem::path& file, std::string comment);

  /// The next line that is neither blank nor a comment; valid until the next call. False at the end. Throws DataError
  /// at the place where a damaged file ends, or at a line beyond 64 MiB.
  bool next(std::string_view& line);

  std::string place() const;  ///< "file:line" of the last line
  /// Bytes of the file that the lines so far took; what is read ahead does not count. Of a gzip file in proportion.
  double used_bytes() const;
  std::uint64_t file_size() const { return bytes_.file_size(); }

 private:
  bool next_raw(std::string_view& line);

  std::string name_;
  std::string comment_;
  compression::ByteStream bytes_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::uint64_t line_ = 0;
};

/// The data rows of a delimited text file, or the records of a binary one, one after the other.
class DelimitedReader {
 public:
  /// Determines the layout from the first rows. Throws DataError if the file cannot be opened or has no data row.
  DelimitedReader(std::filesystem::path file, Format format);

  /// Moves to the next data row; false at the end. Throws DataError as LineReader does.
  bool next();
  Row row() const { return records_ ? records_->fields() : fields_; }
  std::string place() const { return records_ ? records_->place() : lines_->place(); }

  const std::vector<std::string>& header() const { return header_; }  ///< of the first header row; may be empty
  const std::filesystem::path& file() const { return file_; }
  /// Bytes of the file that the rows so far took.
  double used_bytes() const { return records_ ? records_->used_bytes() : lines_->used_bytes(); }
  std::uint64_t file_size() const { return records_ ? records_->file_size() : lines_->file_size(); }

 private:
  void determine_layout();

  std::filesystem::path file_;
  Format format_;
  char delimiter_ = ',';
  int header_rows_ = 0;
  std::vector<std::string> header_;
  std::unique_ptr<LineReader> lines_;
  std::unique_ptr<RecordReader> records_;  // instead of lines
  std::vector<std::string_view> fields_;
};

}  // namespace waymark::csv
