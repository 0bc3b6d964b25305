// SPDX-License-Identifier: Apache-2.0
#include "log_lines.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>

#include "waymark/base/error.hpp"

namespace waymark::carmen {
namespace {

constexpr std::size_t kFirstBuffer = std::size_t{1} << 16;
constexpr std::size_t kLongestLine = std::size_t{1} << 24;

}  // namespace

LogLines::LogLines(const std::filesystem::path& file)
    : name_(file.string()), file_(::gzopen(name_.c_str(), "rb")), buffer_(kFirstBuffer) {
  if (file_ == nullptr) throw DataError(fmt::format("{}: cannot be read: {}", name_, std::strerror(errno)));
}

LogLines::~LogLines() { ::gzclose(file_); }

std::string LogLines::place() const { return fmt::format("{}:{}", name_, line_); }

std::size_t LogLines::refill() {
  const int count = ::gzread(file_, buffer_.data() + end_, static_cast<unsigned>(buffer_.size() - end_));
  // A stream that ends early gives its bytes first, and shows the fault only where there are no more.
  int fault = Z_OK;
  const char* const why = ::gzerror(file_, &fault);
  if (count < 0 || (count == 0 && fault != Z_OK && fault != Z_STREAM_END)) {
    const bool early = fault == Z_BUF_ERROR;
    throw DataError(
        fmt::format("{}:{}: {}", name_, line_ + 1,
                    early ? "the gzip stream ends early" : fmt::format("the gzip stream is damaged: {}", why)));
  }
  end_ += static_cast<std::size_t>(count);
  return static_cast<std::size_t>(count);
}

bool LogLines::next(std::string_view& line) {
  std::size_t searched = begin_;
  for (;;) {
    if (const void* found = std::memchr(buffer_.data() + searched, '\n', end_ - searched)) {
      const auto length = static_cast<std::size_t>(static_cast<const char*>(found) - (buffer_.data() + begin_));
      line = {buffer_.data() + begin_, length};
      begin_ += length + 1;
      break;
    }
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
    searched = end_;
    if (end_ == buffer_.size()) {
      if (buffer_.size() >= kLongestLine)
        throw DataError(fmt::format("{}:{}: the line is longer than 16 MiB", name_, line_ + 1));
      buffer_.resize(2 * buffer_.size());
    }
    if (refill() > 0) continue;
    if (end_ == 0) return false;
    line = {buffer_.data(), end_};
    begin_ = end_;
    break;
  }
  ++line_;
  if (line.ends_with('\r')) line.remove_suffix(1);
  return true;
}

}  // namespace waymark::carmen
