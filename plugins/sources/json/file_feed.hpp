// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <fstream>
#include <vector>

#include "line_feed.hpp"

namespace waymark::json {

/// The lines of a file.
class FileFeed final : public LineFeed {
 public:
  FileFeed(const std::filesystem::path& file, std::size_t longest_line);

  bool next(FedLine& line) override;
  void stop() override {}
  double progress() const override;

 private:
  std::ifstream stream_;
  std::uint64_t size_ = 0;
  std::uint64_t consumed_ = 0;
  std::vector<char> buffer_;
  live::LineSplitter splitter_;
  std::deque<live::Line> lines_;
  std::shared_ptr<const std::string> origin_;
  bool ended_ = false;
};

}  // namespace waymark::json
