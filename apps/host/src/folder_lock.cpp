// SPDX-License-Identifier: Apache-2.0
#include "waymark/host/folder_lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "waymark/base/error.hpp"

namespace waymark::host {

FolderLock::FolderLock(const std::filesystem::path& folder)
    : descriptor_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  const auto because = [](int error) { return std::generic_category().message(error); };
  if (descriptor_ < 0) throw Error(fmt::format("{}: the output folder: {}", folder.string(), because(errno)));
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) == 0) return;
  const int error = errno;
  // Some network file systems lock no folders.
  if (error == ENOLCK || error == EOPNOTSUPP || error == EINVAL) return;
  ::close(descriptor_);
  throw Error(fmt::format("{}: another run writes to this folder; choose another one with --out", folder.string()));
}

FolderLock::~FolderLock() { ::close(descriptor_); }

}  // namespace waymark::host
