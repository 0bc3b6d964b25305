// SPDX-License-Identifier: Apache-2.0
#include "bytes_file.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "waymark/base/error.hpp"

namespace waymark::radar {
namespace {

constexpr std::size_t kLongestLine = 1 << 16;
constexpr unsigned kBuffer = 1 << 16;

}  // namespace

BytesFile::BytesFile(const std::filesystem::path& file) : name_(file.string()) {
  std::error_code error;
  size_ = std::filesystem::file_size(file, error);
  if (error) throw DataError(name_ + ": cannot be read: " + error.message());
  errno = 0;
  file_.reset(gzopen(name_.c_str(), "rb"));
  if (!file_) throw DataError(name_ + ": cannot be read: " + std::strerror(errno));
  gzbuffer(file_.get(), kBuffer);
}

std::size_t BytesFile::read(void* data, std::size_t size) {
  std::size_t filled = 0;
  while (filled < size) {
    const auto most = static_cast<unsigned>(std::min(size - filled, std::size_t{1} << 20));
    const int count = gzread(file_.get(), static_cast<char*>(data) + filled, most);
    if (count < 0) fail();
    if (count == 0) break;
    filled += static_cast<std::size_t>(count);
  }
  // A gzip stream that ends early gives what it has, and its error only when asked.
  int error = Z_OK;
  gzerror(file_.get(), &error);
  if (filled < size && error != Z_OK) fail();
  return filled;
}

bool BytesFile::line(std::string& text) {
  text.clear();
  std::array<char, 1024> part{};
  while (gzgets(file_.get(), part.data(), static_cast<int>(part.size())) != nullptr) {
    text += part.data();
    if (text.ends_with('\n')) {
      text.pop_back();
      if (text.ends_with('\r')) text.pop_back();
      return true;
    }
    if (text.size() > kLongestLine) throw DataError(name_ + ": a line of more than 65536 bytes");
  }
  int error = Z_OK;
  gzerror(file_.get(), &error);
  if (error != Z_OK && error != Z_STREAM_END) fail();
  return !text.empty();
}

void BytesFile::rewind() { gzrewind(file_.get()); }

double BytesFile::progress() const {
  const auto at = gzoffset(file_.get());
  if (size_ == 0 || at < 0) return 0.0;
  return std::min(1.0, static_cast<double>(at) / static_cast<double>(size_));
}

void BytesFile::fail() const {
  int error = Z_OK;
  const char* reason = gzerror(file_.get(), &error);
  throw DataError(name_ + ": the gzip stream is damaged or ends early: " + reason);
}

}  // namespace waymark::radar
