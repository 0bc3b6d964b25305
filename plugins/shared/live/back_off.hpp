// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <chrono>

namespace waymark::live {

/// How long to wait before the next attempt to connect: 0.1 s, then twice as long each time, 5 s at most.
class BackOff {
 public:
  using Wait = std::chrono::milliseconds;

  Wait next() {
    const Wait wait = next_;
    next_ = std::min(2 * next_, kLongest);
    return wait;
  }
  void reset() { next_ = kShortest; }

 private:
  static constexpr Wait kShortest{100};
  static constexpr Wait kLongest{5000};
  Wait next_ = kShortest;
};

}  // namespace waymark::live
