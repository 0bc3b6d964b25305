// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/compression/byte_stream.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>

#include "waymark/base/error.hpp"

namespace waymark::compression {
namespace {

constexpr std::size_t kInputBytes = 1 << 16;
constexpr unsigned char kMagic0 = 0x1f;
constexpr unsigned char kMagic1 = 0x8b;
constexpr int kGzipWindow = 15 + 16;  // the largest window, gzip framing with its checksum

}  // namespace

struct ByteStream::Inflater {
  z_stream stream{};

  Inflater() {
    if (inflateInit2(&stream, kGzipWindow) != Z_OK) throw DataError("zlib cannot start");
  }
  ~Inflater() { inflateEnd(&stream); }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;
};

ByteStream::ByteStream(const std::filesystem::path& file) : name_(file.string()), input_(kInputBytes) {
  descriptor_ = ::open(name_.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor_ < 0) throw DataError(name_ + ": cannot be read: " + std::strerror(errno));
  try {
    struct stat status {};
    if (::fstat(descriptor_, &status) != 0) throw DataError(name_ + ": cannot be read: " + std::strerror(errno));
    if (S_ISDIR(status.st_mode)) throw DataError(name_ + ": is a folder, a file is expected");
    file_size_ = static_cast<std::uint64_t>(status.st_size);
    is_regular_ = S_ISREG(status.st_mode);
    refill();
    const auto byte = [this](std::size_t i) { return static_cast<unsigned char>(input_[i]); };
    if (input_end_ >= 2 && byte(0) == kMagic0 && byte(1) == kMagic1) inflater_ = std::make_unique<Inflater>();
  } catch (...) {
    ::close(descriptor_);
    throw;
  }
}

ByteStream::~ByteStream() { ::close(descriptor_); }

std::uint64_t ByteStream::most_left() const {
  if (!is_regular_) return std::numeric_limits<std::uint64_t>::max();
  const std::uint64_t rest = file_size_ - std::min(consumed_, file_size_);
  // Deflate makes at most 258 bytes of two bits; as many may be on their way.
  constexpr std::uint64_t kMostTimes = 1032;
  if (!inflater_) return rest;
  return rest < std::numeric_limits<std::uint64_t>::max() / kMostTimes - 1 ? (rest + 1) * kMostTimes
                                                                           : std::numeric_limits<std::uint64_t>::max();
}

std::size_t ByteStream::read(char* data, std::size_t size) {
  if (inflater_) {
    const std::size_t count = read_gzip(data, size);
    produced_ += count;
    return count;
  }
  if (input_begin_ < input_end_) {
    const std::size_t count = std::min(size, input_end_ - input_begin_);
    std::memcpy(data, input_.data() + input_begin_, count);
    input_begin_ += count;
    consumed_ += count;
    produced_ += count;
    return count;
  }
  const std::size_t count = read_file(data, size);
  consumed_ += count;
  produced_ += count;
  return count;
}

std::size_t ByteStream::read_file(char* data, std::size_t size) {
  for (;;) {
    const ssize_t count = ::read(descriptor_, data, size);
    if (count >= 0) return static_cast<std::size_t>(count);
    if (errno != EINTR) throw DataError(name_ + ": cannot be read on: " + std::strerror(errno));
  }
}

bool ByteStream::refill() {
  input_begin_ = 0;
  input_end_ = read_file(input_.data(), input_.size());
  return input_end_ > 0;
}

bool ByteStream::next_member() {
  // A gzip file is a chain of members; some writers pad it with zeros.
  const auto current = [this] { return static_cast<unsigned char>(input_[input_begin_]); };
  for (;;) {
    if (input_begin_ == input_end_ && !refill()) return false;
    if (current() != 0) break;
    ++input_begin_;
    ++consumed_;
  }
  if (current() != kMagic0) {
    problem_ = "there are other bytes after the end of the gzip stream";
    return false;
  }
  inflateReset(&inflater_->stream);
  return true;
}

std::size_t ByteStream::read_gzip(char* data, std::size_t size) {
  z_stream& stream = inflater_->stream;
  std::size_t filled = 0;
  while (filled == 0 && !ended_) {
    if (input_begin_ == input_end_ && !refill()) {
      problem_ = "the gzip stream ends early";
      ended_ = true;
      break;
    }
    stream.next_in = reinterpret_cast<Bytef*>(input_.data() + input_begin_);
    stream.avail_in = static_cast<uInt>(input_end_ - input_begin_);
    stream.next_out = reinterpret_cast<Bytef*>(data);
    stream.avail_out = static_cast<uInt>(size);
    const int status = inflate(&stream, Z_NO_FLUSH);
    const std::size_t used = (input_end_ - input_begin_) - stream.avail_in;
    input_begin_ += used;
    consumed_ += used;
    filled = size - stream.avail_out;
    if (status == Z_STREAM_END) {
      ended_ = !next_member();
    } else if (status != Z_OK && status != Z_BUF_ERROR) {
      problem_ = "the gzip stream is damaged";
      ended_ = true;
    }
  }
  return filled;
}

}  // namespace waymark::compression
