// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "waymark/base/time.hpp"

namespace waymark::fusion {

/// A map that matches all six of the pose lies to gravity as the robot was believed to stand at its first scan, for
/// ever. Where a sensor observes roll and pitch, the first scan is therefore the first one after it has found them; but
/// a sensor that never does must not keep the map from being begun.
class LevelWait {
 public:
  /// σ of roll and pitch [rad]: a quarter of that at the start, which no robot falls below unless a sensor has found
  /// its level. To wait for less would be no gain, since gravity is seen best while the robot stands.
  static constexpr double kLevel = 0.0425;
  static constexpr Duration kPatience = std::chrono::seconds(10);  ///< since the first scan

  enum class State { waits, begins, begins_askew, has_begun };

  /// The first scan for a map, and those after it. `sigma`: of roll and pitch [rad], the larger one.
  State at(Time stamp, double sigma) {
    if (over_) return State::has_begun;
    if (!since_) since_ = stamp;
    const bool is_level = sigma <= kLevel;
    if (!is_level && stamp - *since_ < kPatience) return State::waits;
    over_ = true;
    return is_level ? State::begins : State::begins_askew;
  }
  /// There is nothing to wait for.
  void end() { over_ = true; }

  template <class Archive>
  void serialize(Archive& archive) {
    archive(over_, since_);
  }

 private:
  bool over_ = false;
  std::optional<Time> since_;
};

}  // namespace waymark::fusion
