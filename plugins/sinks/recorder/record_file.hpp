// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

namespace waymark::recorder {

/// A file that grows and is whole up to its last write at any time. An older file of the same name is kept, under the
/// next free number: flight.mcap becomes flight.1.mcap.
class RecordFile {
 public:
  /// Throws Error if it cannot be created.
  explicit RecordFile(std::filesystem::path path);
  ~RecordFile();
  RecordFile(const RecordFile&) = delete;
  RecordFile& operator=(const RecordFile&) = delete;

  /// Appends and hands over to the disk. Throws Error with the system's reason; the file then ends where it did before.
  void append(std::span<const std::uint8_t> bytes);

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace waymark::recorder
