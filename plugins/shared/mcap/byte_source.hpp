// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "plugins/shared/cdr/wire_reader.hpp"

namespace waymark::mcap {

/// Bytes that are read in pieces.
class ByteSource {
 public:
  virtual ~ByteSource() = default;
  virtual std::uint64_t size() const = 0;
  /// Exactly `count` bytes, which must lie within. Throws DataError if they cannot be read.
  virtual std::vector<std::uint8_t> read(std::uint64_t offset, std::size_t count) = 0;
};

/// A file. Small pieces are read from a window, so that a walk from record to record takes few calls of the system.
class FileBytes final : public ByteSource {
 public:
  /// Throws DataError if it cannot be opened or is not a regular file.
  explicit FileBytes(std::filesystem::path file);
  ~FileBytes() override;
  FileBytes(const FileBytes&) = delete;
  FileBytes& operator=(const FileBytes&) = delete;

  std::uint64_t size() const override { return size_; }
  std::vector<std::uint8_t> read(std::uint64_t offset, std::size_t count) override;

 private:
  void read_into(std::uint64_t offset, std::vector<std::uint8_t>& bytes);

  std::filesystem::path file_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
  std::uint64_t window_start_ = 0;
  std::vector<std::uint8_t> window_;
};

/// Bytes in memory.
class MemoryBytes final : public ByteSource {
 public:
  explicit MemoryBytes(std::vector<std::uint8_t> bytes) : bytes_(std::move(bytes)) {}
  std::uint64_t size() const override { return bytes_.size(); }
  std::vector<std::uint8_t> read(std::uint64_t offset, std::size_t count) override {
    const ros::Bytes piece = ros::Bytes(bytes_).subspan(offset, count);
    return {piece.begin(), piece.end()};
  }

 private:
  std::vector<std::uint8_t> bytes_;
};

}  // namespace waymark::mcap
