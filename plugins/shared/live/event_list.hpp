// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <mutex>
#include <string>
#include <vector>

namespace waymark::live {

/// What happened to a live source or sink, for `take_events`. Safe to use from several threads. Takes 100 events, and
/// 5 more with every second: peers that come and go must fill neither the memory nor the log. Of the rest there is a
/// count, every 10 s at most.
class EventList {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kMost = 100;

  void add(std::string text, Clock::time_point now = Clock::now());
  std::vector<std::string> take(Clock::time_point now = Clock::now());

 private:
  std::mutex mutex_;
  std::vector<std::string> events_;
  Clock::time_point newest_{};  // added or left out
  double room_ = kMost;         // events that are taken
  std::size_t left_out_ = 0;
  Clock::time_point counted_{};  // when there was a count last
};

}  // namespace waymark::live
