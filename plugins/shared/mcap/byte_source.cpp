// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/mcap/byte_source.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "waymark/base/error.hpp"

namespace waymark::mcap {
namespace {

constexpr std::size_t kWindow = std::size_t{1} << 16;
constexpr std::size_t kSmall = std::size_t{1} << 12;

}  // namespace

FileBytes::FileBytes(std::filesystem::path file) : file_(std::move(file)) {
  std::error_code ignored;
  if (std::filesystem::is_directory(file_, ignored))
    throw DataError(file_.string() + ": is a folder, a file is expected");
  descriptor_ = ::open(file_.c_str(), O_RDONLY | O_CLOEXEC);
  struct stat status {};
  if (descriptor_ < 0 || ::fstat(descriptor_, &status) != 0) {
    const int reason = errno;
    if (descriptor_ >= 0) ::close(descriptor_);
    throw DataError(fmt::format("{}: cannot be read: {}", file_.string(), std::strerror(reason)));
  }
  size_ = static_cast<std::uint64_t>(status.st_size);
}

FileBytes::~FileBytes() { ::close(descriptor_); }

void FileBytes::read_into(std::uint64_t offset, std::vector<std::uint8_t>& bytes) {
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t got =
        ::pread(descriptor_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) {
      throw DataError(fmt::format("{}:byte {}: cannot be read on: {}", file_.string(), offset + done,
                                  got < 0 ? std::strerror(errno) : "the file has become shorter"));
    }
    done += static_cast<std::size_t>(got);
  }
}

std::vector<std::uint8_t> FileBytes::read(std::uint64_t offset, std::size_t count) {
  std::vector<std::uint8_t> bytes(count);
  if (count > kSmall) {
    read_into(offset, bytes);
    return bytes;
  }
  if (offset < window_start_ || offset + count > window_start_ + window_.size()) {
    window_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(kWindow, size_ - offset)));
    window_start_ = offset;
    read_into(offset, window_);
  }
  std::copy_n(window_.begin() + static_cast<std::ptrdiff_t>(offset - window_start_), count, bytes.begin());
  return bytes;
}

}  // namespace waymark::mcap
