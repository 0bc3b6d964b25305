// SPDX-License-Identifier: Apache-2.0
#include "live_feed.hpp"

#include <utility>

namespace waymark::json {

bool LiveFeed::next(FedLine& line) {
  if (stopped_) return false;
  if (!std::exchange(opened_, true)) open();
  while (lines_.empty()) {
    context_.run_one();
    if (stopped_) return false;
  }
  line = std::move(lines_.front());
  lines_.pop_front();
  return true;
}

void LiveFeed::stop() {
  stopped_ = true;
  context_.stop();
}

}  // namespace waymark::json
