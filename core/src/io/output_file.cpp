// SPDX-License-Identifier: Apache-2.0
#include "waymark/io/output_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <system_error>
#include <utility>

#include "waymark/base/error.hpp"
#include "waymark/io/written_files.hpp"

namespace waymark {
namespace {

constexpr std::size_t kBufferSize = std::size_t{1} << 16;

std::filesystem::path partial_of(const std::filesystem::path& path) {
  std::filesystem::path partial = path;
  partial += kPartialSuffix;
  return partial;
}

[[noreturn]] void throw_error(const std::filesystem::path& path, const char* doing, int system_error) {
  throw Error(fmt::format("{}: {}: {}", path.string(), doing, std::generic_category().message(system_error)));
}

int create(const std::filesystem::path& path, const std::filesystem::path& partial) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) throw_error(path, "creating", EISDIR);
  // A file of our own making: what somebody has put there, a link to another file for example, is not written to.
  ::unlink(partial.c_str());
  const int descriptor = ::open(partial.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
  if (descriptor < 0) throw_error(path, "creating", errno);
  return descriptor;
}

/// Gives the partial file its name. Returns the system's error or 0; EBUSY if another program has replaced the partial
/// file meanwhile.
int put_in_place(int descriptor, const std::filesystem::path& partial, const std::filesystem::path& path) {
  struct stat ours {};
  struct stat there {};
  if (::fstat(descriptor, &ours) != 0 || ::lstat(partial.c_str(), &there) != 0) return errno;
  if (ours.st_ino != there.st_ino || ours.st_dev != there.st_dev) return EBUSY;
  return std::rename(partial.c_str(), path.c_str()) == 0 ? 0 : errno;
}

/// Writes until all is written or the system reports an error; `done`: bytes written. Returns the system's error or 0.
int write_all(int descriptor, std::string_view text, std::size_t& done) {
  done = 0;
  while (done < text.size()) {
    const ssize_t count = ::write(descriptor, text.data() + done, text.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return errno;
    if (count == 0) return ENOSPC;
    done += static_cast<std::size_t>(count);
  }
  return 0;
}

/// Returns the system's error or 0. Some file systems cannot sync; this is ignored.
int sync(int descriptor) {
  if (::fsync(descriptor) == 0 || errno == EINVAL || errno == ENOTSUP) return 0;
  return errno;
}

}  // namespace

OutputFile::OutputFile(std::filesystem::path path) : path_(std::move(path)), partial_(partial_of(path_)) {
  descriptor_ = create(path_, partial_);
}

OutputFile::~OutputFile() {
  if (descriptor_ < 0) return;
  ::close(descriptor_);
  ::unlink(partial_.c_str());
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : path_(std::move(other.path_)),
      partial_(std::move(other.partial_)),
      buffer_(std::move(other.buffer_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      written_(other.written_),
      last_line_end_(other.last_line_end_) {}

void OutputFile::write(std::string_view text) {
  if (descriptor_ < 0) throw_error(path_, "writing after it was closed", EBADF);
  buffer_.append(text);
  if (buffer_.size() >= kBufferSize) flush();
}

void OutputFile::flush() {
  std::size_t done = 0;
  const int error = write_all(descriptor_, buffer_, done);
  const std::size_t newline = std::string_view(buffer_).substr(0, done).rfind('\n');
  if (newline != std::string_view::npos) last_line_end_ = written_ + newline + 1;
  written_ += done;
  buffer_.clear();
  if (error != 0) fail("writing", error);
}

void OutputFile::commit() {
  if (descriptor_ < 0) throw_error(path_, "writing after it was closed", EBADF);
  flush();
  if (const int error = sync(descriptor_); error != 0) fail("syncing", error);
  const int error = put_in_place(descriptor_, partial_, path_);
  const bool closed = ::close(std::exchange(descriptor_, -1)) == 0;
  const int close_error = errno;
  if (error != 0) throw_error(path_, "renaming", error);
  note_written(path_);
  if (!closed) throw_error(path_, "closing", close_error);
}

void OutputFile::fail(const char* doing, int system_error) {
  const bool cut = ::ftruncate(descriptor_, static_cast<off_t>(last_line_end_)) == 0;
  // Without a complete line there is no file: an empty one would hide an older one.
  if (!cut || last_line_end_ == 0 || put_in_place(descriptor_, partial_, path_) != 0) {
    ::unlink(partial_.c_str());
  } else {
    note_written(path_);
  }
  ::close(std::exchange(descriptor_, -1));
  throw_error(path_, doing, system_error);
}

void write_file(const std::filesystem::path& path, std::string_view content, Belongs belongs) {
  const std::filesystem::path partial = partial_of(path);
  const int descriptor = create(path, partial);
  std::size_t done = 0;
  const char* doing = "writing";
  int error = write_all(descriptor, content, done);
  if (error == 0) {
    doing = "syncing";
    error = sync(descriptor);
  }
  if (error == 0) {
    doing = "renaming";
    error = put_in_place(descriptor, partial, path);
  }
  if (::close(descriptor) != 0 && error == 0) throw_error(path, "closing", errno);
  if (error == 0) {
    if (belongs == Belongs::to_run) note_written(path);
    return;
  }
  ::unlink(partial.c_str());
  throw_error(path, doing, error);
}

void create_folder(const std::filesystem::path& folder, std::string_view what) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw Error(fmt::format("{}: cannot create the {}: {}", folder.string(), what, error.message()));
}

}  // namespace waymark
