// SPDX-License-Identifier: Apache-2.0
#include "motion_costs.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace waymark::host::diagnosis {

namespace {

constexpr double kUnlikely = 3.0;  // cost of an explanation that takes an unusual mistake
constexpr double kUsual = 1.0;     // of one that everybody makes
constexpr double kTelling = 0.2;   // of one that something else points to

/// True if a receiver's speed is in another unit.
bool is_speed_unit(double ratio) {
  constexpr std::array<double, 6> kUnits{3.6, 1.0 / 3.6, 1.9438, 0.5144, 2.2369, 1000.0};
  return std::ranges::any_of(kUnits, [&](double unit) { return is_near(ratio, unit); });
}

/// Of a scanner that moves backwards: 1 if it finds its own lever arm (it is turned round), −1 if it finds the reversed
/// one (the wheels count backwards), 0 if neither is clear.
int lever_evidence(const Case& c, const MotionAgreement& motion) {
  for (std::size_t i = 0; i < motion.mountings.size(); ++i) {
    const MountingFit& mounting = motion.mountings[i];
    const Eigen::Vector2d lever = c.sensor(i).T_base_sensor.p.head<2>();
    if (!mounting.is_known || lever.norm() < 0.02) continue;
    const double shown = mounting.lever.dot(lever) / lever.norm();
    if (std::abs(shown) > 4.0 * mounting.lever_sigma.maxCoeff()) return shown > 0.0 ? 1 : -1;
  }
  return 0;
}

}  // namespace

double cost_of_yaw(const Case& c, std::size_t i, const Ratio& ratio, const Scales& scales) {
  const WatchedSensor& sensor = c.sensor(i);
  if (c.is_blamed(i)) return kTelling;
  const bool mirrored = is_near(ratio.value, -1.0);
  const bool degrees = is_near(std::abs(ratio.value), 1.0 / kDegree);
  switch (sensor.role()) {
    case Role::wheels:
      if (is_one_scale(sensor, scales)) return 0.5 * kUsual;
      return ratio.verdict == Ratio::Verdict::unrelated ? kUnlikely : kUsual;
    case Role::gyro:
      if (mirrored || degrees || ratio.verdict == Ratio::Verdict::unrelated || is_near(ratio.value, kDegree))
        return kUsual;
      // The full scale of the chip taken for another one.
      return is_near(ratio.value, 2.0) || is_near(ratio.value, 0.5) ? 1.2 * kUsual : kUnlikely;
    case Role::scanner:
      // Few scanners deliver mirrored scans whose beams count counter-clockwise.
      if (mirrored) return sensor.steps_backwards ? kTelling : 1.2 * kUsual;
      // Half a degree from beam to beam taken for one, or the reverse.
      return is_near(ratio.value, 2.0) || is_near(ratio.value, 0.5) ? 1.2 * kUsual : kUnlikely;
    case Role::heading:
      return mirrored || ratio.verdict == Ratio::Verdict::unrelated ? kUsual : kUnlikely;
    case Role::fix:
      return mirrored ? 1.2 * kUsual : kUnlikely;
    case Role::other:
      break;
  }
  return kUsual;
}

double cost_of_way(const Case& c, const MotionAgreement& motion, const Observer& observer, const Ratio& ratio,
                   const Scales& scales) {
  const WatchedSensor& sensor = c.sensor(observer.sensor);
  if (c.is_blamed(observer.sensor)) return kTelling;
  const bool turns_fit = scales.yaw && is_near(*scales.yaw, 1.0);
  switch (sensor.role()) {
    case Role::wheels:
      if (ratio.value < 0.0 && lever_evidence(c, motion) > 0) return kUnlikely;
      if (is_one_scale(sensor, scales)) return kTelling;
      if (sensor.usual.yaw_scales_with_speed && turns_fit) return kUnlikely;
      // Ways that are reversed while turns are right: a scanner that is turned round makes the same, and more often.
      return ratio.value < 0.0 && turns_fit ? 1.5 * kUsual : kUsual;
    case Role::scanner:
      if (ratio.value > 0.0) return is_near(ratio.value, 1000.0) || is_near(ratio.value, 0.001) ? kTelling : kUsual;
      if (const int lever = lever_evidence(c, motion); lever != 0) return lever > 0 ? 0.0 : kUnlikely;
      return sensor.steps_backwards ? kTelling : kUsual;
    case Role::fix:
      if (observer.kind == Observer::Kind::course) return is_speed_unit(ratio.value) ? kUsual : kUnlikely;
      return kUnlikely;
    default:
      break;
  }
  return kUsual;
}

}  // namespace waymark::host::diagnosis
