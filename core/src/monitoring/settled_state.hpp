// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>
#include <string_view>

#include "waymark/base/time.hpp"

namespace waymark::monitoring {

/// A state with hysteresis: a worse verdict counts once it has lasted, a better one once it has lasted longer. `State`
/// is an enumeration in order of severity, from 0 on.
template <class State>
class SettledState {
 public:
  static constexpr Duration kWorseAfter = std::chrono::milliseconds(500);
  static constexpr Duration kBetterAfter = std::chrono::seconds(2);

  /// Takes the verdict at `now`. A worse one that `is_certain` counts at once. Changes state and reason in place.
  void settle(State verdict, std::string_view why, bool is_certain, Time now, State& state, std::string& reason) {
    if (verdict == state) {
      is_pending_ = false;
      set(reason, why);
      return;
    }
    const bool is_worse = verdict > state;
    if (!is_pending_ || is_worse != is_worse_) {
      is_pending_ = true;
      is_worse_ = is_worse;
      since_ = now;
    }
    if (!(is_worse && is_certain) && now - since_ < (is_worse ? kWorseAfter : kBetterAfter)) return;
    is_pending_ = false;
    state = verdict;
    set(reason, why);
  }

  template <class Archive>
  void serialize(Archive& archive) {
    archive(is_pending_, is_worse_, since_);
  }

 private:
  /// Assigns the text only if it changes: called thousands of times a second, and a copy allocates.
  static void set(std::string& reason, std::string_view why) {
    if (reason != why) reason = why;
  }

  bool is_pending_ = false;  // the verdict differs from the state
  bool is_worse_ = false;
  Time since_{};
};

}  // namespace waymark::monitoring
