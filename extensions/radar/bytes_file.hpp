// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <zlib.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

namespace waymark::radar {

/// The bytes of a file, plain or gzip.
class BytesFile {
 public:
  /// Throws DataError if it cannot be opened.
  explicit BytesFile(const std::filesystem::path& file);

  /// Reads up to `size` bytes, less only at the end. Throws DataError if the file is damaged.
  std::size_t read(void* data, std::size_t size);
  /// Reads one line without its end; false at the end. Throws DataError if the file is damaged, or the line too long.
  bool line(std::string& text);

  void rewind();
  double progress() const;  ///< share of the file that was read, 0 to 1
  const std::string& name() const { return name_; }

 private:
  struct Close {
    void operator()(gzFile_s* file) const { gzclose_r(file); }
  };
  [[noreturn]] void fail() const;

  std::string name_;
  std::uint64_t size_ = 0;
  std::unique_ptr<gzFile_s, Close> file_;
};

}  // namespace waymark::radar
