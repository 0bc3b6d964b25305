// SPDX-License-Identifier: Apache-2.0
#include "record_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "waymark/base/error.hpp"

namespace waymark::recorder {
namespace {

void keep_older(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return;
  for (int number = 1;; ++number) {
    const std::filesystem::path kept =
        path.parent_path() / fmt::format("{}.{}{}", path.stem().string(), number, path.extension().string());
    if (std::filesystem::exists(kept, error)) continue;
    std::filesystem::rename(path, kept, error);
    if (error) throw Error(fmt::format("{}: cannot be renamed: {}", path.string(), error.message()));
    return;
  }
}

}  // namespace

RecordFile::RecordFile(std::filesystem::path path) : path_(std::move(path)) {
  keep_older(path_);
  constexpr int kMode = 0644;
  descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, kMode);
  if (descriptor_ < 0) throw Error(fmt::format("{}: cannot be created: {}", path_.string(), std::strerror(errno)));
}

RecordFile::~RecordFile() { ::close(descriptor_); }

void RecordFile::append(std::span<const std::uint8_t> bytes) {
  int reason = 0;
  std::size_t done = 0;
  while (done < bytes.size() && reason == 0) {
    const ssize_t written = ::write(descriptor_, bytes.data() + done, bytes.size() - done);
    if (written >= 0) {
      done += static_cast<std::size_t>(written);
    } else if (errno != EINTR) {
      reason = errno;
    }
  }
  // Some systems have no such call for some files; the data are written then as well.
  if (reason == 0 && ::fdatasync(descriptor_) != 0 && errno != EINVAL && errno != EROFS) reason = errno;
  if (reason == 0) {
    size_ += bytes.size();
    return;
  }
  // Part of a chunk is of little use, and a full disk needs the room.
  const bool is_cut = ::ftruncate(descriptor_, static_cast<off_t>(size_)) == 0;
  throw Error(fmt::format("{}: cannot be written: {}{}", path_.string(), std::strerror(reason),
                          is_cut ? "" : "; its end is incomplete"));
}

}  // namespace waymark::recorder
