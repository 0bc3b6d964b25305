// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace waymark::compression {

/// A file as it is, or one that was packed as a whole (.gz, .zst, .zstd), unpacked into a temporary file that exists as
/// long as this.
class UnpackedFile {
 public:
  /// Throws DataError if it cannot be read or unpacked.
  explicit UnpackedFile(std::filesystem::path file);
  ~UnpackedFile();
  UnpackedFile(UnpackedFile&& other) noexcept;
  UnpackedFile& operator=(UnpackedFile&&) = delete;

  /// What to open.
  const std::filesystem::path& path() const { return temporary_.empty() ? file_ : temporary_; }
  /// Name for messages.
  const std::filesystem::path& name() const { return file_; }

 private:
  std::filesystem::path file_;
  std::filesystem::path temporary_;  // empty: there is none
};

}  // namespace waymark::compression
