// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "waymark/interface/snapshot.hpp"

namespace waymark::fusion {

/// Which events of a list were taken already. The list grows, and a rollback cuts it.
class NewEvents {
 public:
  /// Appends those of `events` that are new to `to`.
  void take(const std::vector<Event>& events, std::vector<Event>& to) {
    for (; taken_ < events.size(); ++taken_) {
      if (!was_cut(events[taken_])) to.push_back(events[taken_]);
    }
    cut_.clear();
  }
  /// Takes all of `events`, and gives them to nobody.
  void skip(const std::vector<Event>& events) {
    taken_ = events.size();
    cut_.clear();
  }
  /// Before `events` is cut to `size`: what is repeated then is not new.
  void roll_back(const std::vector<Event>& events, std::size_t size) {
    for (std::size_t i = size; i < taken_; ++i) cut_.push_back(events[i]);
    taken_ = std::min(taken_, size);
  }

 private:
  bool was_cut(const Event& event) {
    const auto same = std::ranges::find_if(
        cut_, [&](const Event& other) { return other.stamp == event.stamp && other.text == event.text; });
    if (same == cut_.end()) return false;
    cut_.erase(same);
    return true;
  }

  std::size_t taken_ = 0;
  std::vector<Event> cut_;  // were taken before a rollback
};

}  // namespace waymark::fusion
