// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <deque>
#include <vector>

#include "line_feed.hpp"
#include "plugins/shared/live/event_list.hpp"

namespace waymark::json {

/// The lines of the standard input, until its end. The input stays blocking, since other programs may share it.
class InputFeed final : public LineFeed {
 public:
  /// `input`: the descriptor; not closed.
  InputFeed(int input, std::size_t longest_line, live::EventList& events);
  ~InputFeed() override;
  InputFeed(const InputFeed&) = delete;
  InputFeed& operator=(const InputFeed&) = delete;

  bool next(FedLine& line) override;
  void stop() override;

 private:
  void read();

  int input_;
  int wake_;  // readable once stopped
  live::EventList& events_;
  live::LineSplitter splitter_;
  std::vector<char> buffer_;
  std::deque<live::Line> lines_;
  std::shared_ptr<const std::string> origin_;
  std::atomic<bool> stopped_ = false;
  bool ended_ = false;
};

}  // namespace waymark::json
