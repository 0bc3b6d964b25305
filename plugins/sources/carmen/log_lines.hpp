// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <zlib.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace waymark::carmen {

/// The lines of a log, plain or gzip, one after the other.
class LogLines {
 public:
  /// Throws DataError if the file cannot be opened.
  explicit LogLines(const std::filesystem::path& file);
  ~LogLines();
  LogLines(const LogLines&) = delete;
  LogLines& operator=(const LogLines&) = delete;

  /// The next line without its end, valid until the next call; false at the end. Throws DataError where a damaged gzip
  /// stream ends, or at a line beyond 16 MiB.
  bool next(std::string_view& line);

  std::string place() const;  ///< "file:line" of the last line

 private:
  std::size_t refill();

  std::string name_;
  gzFile file_ = nullptr;
  std::vector<char> buffer_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::uint64_t line_ = 0;
};

}  // namespace waymark::carmen
