// SPDX-License-Identifier: Apache-2.0
#include "motion_scales.hpp"

namespace waymark::host::diagnosis {

namespace {

/// The sensor's ratio to a group, or with `group` < 0 to any other sensor; the last one that is known.
std::optional<double> scale_of(const Agreement& agreement, std::size_t sensor, int group) {
  std::optional<double> scale;
  for (std::size_t i = 0; i < agreement.observers.size(); ++i) {
    if (agreement.observers[i].sensor != sensor) continue;
    for (std::size_t j = 0; j < agreement.observers.size(); ++j) {
      const bool counts = group < 0 ? agreement.observers[j].sensor != sensor : agreement.groups[j] == group;
      const Ratio& ratio = agreement.ratios[i][j];
      if (counts && ratio.verdict != Ratio::Verdict::unknown) scale = ratio.value;
    }
  }
  return scale;
}

}  // namespace

bool is_one_scale(const WatchedSensor& sensor, const Scales& scales) {
  if (!sensor.usual.yaw_scales_with_speed || !scales.yaw || !scales.way || !is_near(*scales.yaw, *scales.way))
    return false;
  // Turns that are right have no scale in common with ways that are 10 % off.
  return std::abs(std::log(*scales.yaw / *scales.way)) < 0.5 * std::abs(std::log(std::abs(*scales.way)));
}

Scales scales_of(const MotionAgreement& motion, std::size_t sensor, int yaw_group) {
  return {scale_of(motion.yaw, sensor, yaw_group), scale_of(motion.way, sensor, -1)};
}

}  // namespace waymark::host::diagnosis
