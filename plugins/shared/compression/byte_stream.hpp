// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace waymark::compression {

/// The bytes of a plain or gzip file (recognised by its first two bytes, not by its name), in order. A damaged gzip
/// file yields every byte before the damage; then `problem` holds what is wrong.
class ByteStream {
 public:
  /// Throws DataError if the file cannot be opened or is a folder.
  explicit ByteStream(const std::filesystem::path& file);
  ~ByteStream();
  ByteStream(const ByteStream&) = delete;
  ByteStream& operator=(const ByteStream&) = delete;

  /// Fills up to `size` bytes; 0 only at the end. Throws DataError if the system cannot read.
  std::size_t read(char* data, std::size_t size);

  /// Empty, or why the stream ended before its proper end. To be asked once `read` returned 0.
  std::string_view problem() const { return problem_; }

  std::uint64_t consumed() const { return consumed_; }  ///< bytes of the file that were used
  std::uint64_t produced() const { return produced_; }  ///< bytes that `read` gave; of a gzip file the expanded ones
  std::uint64_t file_size() const { return file_size_; }
  /// At most so many bytes are left for `read`, so a size that a damaged file states can be doubted at once: the rest
  /// of the file, or what the rest of a gzip file expands to at best; of a pipe any number.
  std::uint64_t most_left() const;

 private:
  struct Inflater;

  std::size_t read_file(char* data, std::size_t size);
  std::size_t read_gzip(char* data, std::size_t size);
  bool refill();
  bool next_member();

  std::string name_;
  int descriptor_ = -1;
  std::uint64_t file_size_ = 0;
  bool is_regular_ = true;
  std::uint64_t consumed_ = 0;
  std::uint64_t produced_ = 0;
  std::vector<char> input_;  // compressed bytes, or the head of a plain file
  std::size_t input_begin_ = 0;
  std::size_t input_end_ = 0;
  std::unique_ptr<Inflater> inflater_;  // null: plain
  bool ended_ = false;
  std::string_view problem_;
};

}  // namespace waymark::compression
