// SPDX-License-Identifier: Apache-2.0
#include "line_stream.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <ctime>
#include <utility>

#include "waymark/base/error.hpp"

namespace waymark::nmea {
namespace {

constexpr std::size_t kBufferBytes = 1 << 14;
/// Waits a little for more to be written; false if a signal came, for the run is to end then.
bool pause() {
  constexpr timespec kPause{0, 20'000'000};
  return ::nanosleep(&kPause, nullptr) == 0;
}

}  // namespace

LineStream::LineStream(std::filesystem::path file, Duration patience)
    : file_(std::move(file)), patience_(patience), buffer_(kBufferBytes) {
  std::error_code ignored;
  is_file_ = file_ != "-" && std::filesystem::is_regular_file(file_, ignored);
}

LineStream::~LineStream() {
  if (descriptor_ > STDIN_FILENO) ::close(descriptor_);
}

std::string LineStream::place() const { return fmt::format("{}:{}", file_ == "-" ? "stdin" : file_.string(), line_); }

double LineStream::progress() const {
  if (!is_file_) return -1.0;
  return size_ == 0 ? 0.0 : std::min(1.0, static_cast<double>(consumed_) / static_cast<double>(size_));
}

bool LineStream::open() {
  descriptor_ = file_ == "-" ? STDIN_FILENO : ::open(file_.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor_ < 0 && errno == EINTR) return false;
  if (descriptor_ < 0) throw DataError(fmt::format("{}: cannot be read: {}", file_.string(), std::strerror(errno)));
  std::error_code ignored;
  if (is_file_) size_ = std::filesystem::file_size(file_, ignored);
  return true;
}

bool LineStream::refill() {
  if (descriptor_ < 0 && !open()) return false;
  const auto give_up = std::chrono::steady_clock::now() + patience_;
  for (;;) {
    const ssize_t count = ::read(descriptor_, buffer_.data(), buffer_.size());
    if (count > 0) {
      begin_ = 0;
      end_ = static_cast<std::size_t>(count);
      return true;
    }
    if (count < 0 && errno == EINTR) return false;  // a signal: the run is to end
    if (count < 0) throw DataError(fmt::format("{}: cannot be read on: {}", place(), std::strerror(errno)));
    if (count == 0) {
      if (!is_file_ || std::chrono::steady_clock::now() >= give_up) return false;
      if (!pause()) return false;
    }
  }
}

bool LineStream::next(std::string& line) {
  line.clear();
  bool any = false;
  for (;;) {
    if (begin_ == end_ && !refill()) {
      if (any) ++line_;
      return any;
    }
    const char c = buffer_[begin_++];
    ++consumed_;
    if (c == '\n' && std::exchange(after_cr_, false)) continue;  // the second half of CR LF
    after_cr_ = c == '\r';
    if (c == '\n' || c == '\r') {
      ++line_;
      return true;
    }
    any = true;
    if (line.size() < kLongest) line += c;
  }
}

}  // namespace waymark::nmea
