// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/live/event_list.hpp"

#include <fmt/format.h>

#include <utility>

namespace waymark::live {

void EventList::add(std::string text) {
  const std::lock_guard lock(mutex_);
  if (events_.size() < kMost) {
    events_.push_back(std::move(text));
  } else {
    ++left_out_;
  }
}

std::vector<std::string> EventList::take() {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> taken = std::exchange(events_, {});
  if (left_out_ > 0) taken.push_back(fmt::format("{} more events", std::exchange(left_out_, 0)));
  return taken;
}

}  // namespace waymark::live
