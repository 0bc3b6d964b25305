// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace waymark::host {

/// Keeps other runs out of an output folder while it lives, also those of other programs (flock(2) on the folder, which
/// ends with the process).
class FolderLock {
 public:
  /// Throws Error if another run writes to the folder, or if it cannot be opened.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_;
};

}  // namespace waymark::host
