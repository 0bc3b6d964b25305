// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <optional>

#include "waymark/base/time.hpp"
#include "waymark/math/pose.hpp"

namespace waymark::particles {

/// Which poses of a path are kept while the robot stays within 0.1 m and 0.2 rad of one pose: all of the first ten
/// minutes, then one after each hundredth of the time so far, and the newest. So their number grows with the logarithm
/// of the time, and a robot that stands for a day takes hardly more memory than one that stands for an hour.
class Stay {
 public:
  /// Takes the next pose of the path. True if it replaces the one before, which is not kept.
  bool replaces_last(Time stamp, const Pose& T_map_base);

  template <class Archive>
  void serialize(Archive& archive) {
    archive(began_, kept_, last_, T_map_begin_.p, T_map_begin_.q);
  }

 private:
  static constexpr Duration kWhole = std::chrono::minutes(10);
  static constexpr int kPartsOfTime = 100;

  std::optional<Time> began_;
  Time kept_{};  // the newest pose but the last
  Time last_{};
  Pose T_map_begin_;
};

}  // namespace waymark::particles
