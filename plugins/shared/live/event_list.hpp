// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <mutex>
#include <string>
#include <vector>

namespace waymark::live {

/// What happened to a live source or sink, for `take_events`. Safe to use from several threads. Keeps the first 100
/// until they are taken; of the rest there is a count.
class EventList {
 public:
  static constexpr std::size_t kMost = 100;

  void add(std::string text);
  std::vector<std::string> take();

 private:
  std::mutex mutex_;
  std::vector<std::string> events_;
  std::size_t left_out_ = 0;
};

}  // namespace waymark::live
