// SPDX-License-Identifier: Apache-2.0
#include "file_feed.hpp"

#include <algorithm>
#include <utility>

#include "waymark/base/error.hpp"

namespace waymark::json {

constexpr std::size_t kBytesOfABlock = 1 << 16;

FileFeed::FileFeed(const std::filesystem::path& file, std::size_t longest_line)
    : stream_(file, std::ios::binary),
      buffer_(kBytesOfABlock),
      splitter_(longest_line, live::LineEnd::lf),
      origin_(std::make_shared<std::string>(file.string() + ":")) {
  std::error_code ignored;
  size_ = std::filesystem::file_size(file, ignored);
}

bool FileFeed::next(FedLine& line) {
  while (lines_.empty()) {
    if (ended_) return false;
    stream_.read(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
    if (stream_.bad()) throw DataError(*origin_ + " cannot be read on");
    const auto count = static_cast<std::size_t>(stream_.gcount());
    consumed_ += count;
    splitter_.add({buffer_.data(), count}, lines_);
    ended_ = count == 0;
    if (ended_) splitter_.finish(lines_);
  }
  line = {std::move(lines_.front()), origin_};
  lines_.pop_front();
  return true;
}

double FileFeed::progress() const {
  return size_ == 0 ? 0.0 : std::min(1.0, static_cast<double>(consumed_) / static_cast<double>(size_));
}

}  // namespace waymark::json
