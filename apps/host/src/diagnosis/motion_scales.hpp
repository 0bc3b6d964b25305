// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <optional>

#include "checks.hpp"

namespace waymark::host::diagnosis {

/// True if two ratios may be one mistake: they differ by no more than 15 %.
inline bool is_near(double value, double expected) { return std::abs(value / expected - 1.0) < 0.15; }

inline bool is_within(double value, double low, double high, double margin) {
  return value > low / margin && value < high * margin;
}

/// A sensor's ratios to the group that is not its own, as far as they are known.
struct Scales {
  std::optional<double> yaw;
  std::optional<double> way;
};

/// True if a sensor has the same mistake in both: wheels whose turns are made of their ways.
bool is_one_scale(const WatchedSensor& sensor, const Scales& scales);

/// A sensor's ratios of turns to a group, or with `yaw_group` < 0 to any other sensor, and of ways to any other.
Scales scales_of(const MotionAgreement& motion, std::size_t sensor, int yaw_group);

}  // namespace waymark::host::diagnosis
