// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "plugins/shared/compression/byte_stream.hpp"
#include "waymark/config/config.hpp"

namespace waymark::csv {

/// Binary records of one length, one after the other: which numbers a record holds. Little-endian, without padding.
struct RecordLayout {
  /// Equal numbers that follow each other.
  struct Run {
    char kind;          ///< 'i', 'u' or 'f': signed, unsigned, floating
    std::size_t bytes;  ///< of a number: 1, 2, 4 or 8
    std::size_t count;
  };

  std::size_t skip_bytes = 0;  ///< before the first record
  std::vector<Run> runs;

  std::size_t bytes() const;  ///< of a record

  /// Reads the mapping `records`. Throws ConfigError.
  static RecordLayout read(const Config& records);
};

/// The records of a binary file, plain or gzip, as rows of texts, so that columns are those of a delimited file.
class RecordReader {
 public:
  /// Throws DataError if the file cannot be opened.
  RecordReader(const std::filesystem::path& file, RecordLayout layout);

  /// Moves to the next record; false at the end. Throws DataError where a damaged file ends, or within a record.
  bool next();
  /// Its numbers, of as many digits as they need; valid until the next call.
  const std::vector<std::string_view>& fields() const { return fields_; }

  std::string place() const;  ///< "file:record n", from 1
  double used_bytes() const { return static_cast<double>(bytes_.consumed()); }
  std::uint64_t file_size() const { return bytes_.file_size(); }

 private:
  std::size_t fill(std::size_t size);

  std::string name_;
  RecordLayout layout_;
  compression::ByteStream bytes_;
  std::vector<char> record_;
  std::string text_;
  std::vector<std::size_t> ends_;  // of each field in the text
  std::vector<std::string_view> fields_;
  std::uint64_t number_ = 0;
  bool is_begun_ = false;
};

}  // namespace waymark::csv
