// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/live/event_list.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace waymark::live {

namespace {

constexpr double kPerSecond = 5.0;
constexpr std::chrono::seconds kBetweenCounts{10};

}  // namespace

void EventList::add(std::string text, Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  const double passed = std::chrono::duration<double>(now - newest_).count();
  room_ = std::min(room_ + kPerSecond * passed, static_cast<double>(kMost));
  newest_ = now;
  if (room_ < 1.0) {
    ++left_out_;
    return;
  }
  room_ -= 1.0;
  events_.push_back(std::move(text));
}

std::vector<std::string> EventList::take(Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> taken = std::exchange(events_, {});
  if (left_out_ > 0 && now - counted_ >= kBetweenCounts) {
    taken.push_back(fmt::format("{} more events", std::exchange(left_out_, 0)));
    counted_ = now;
  }
  return taken;
}

}  // namespace waymark::live
