// SPDX-License-Identifier: Apache-2.0
#include "motion_costs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "waymark/math/so3.hpp"

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

/// True if positions are in another unit of length.
bool is_length_unit(double ratio) {
  constexpr std::array<double, 6> kUnits{1.0 / 0.3048, 0.3048, 1000.0, 0.001, 100.0, 0.01};
  return std::ranges::any_of(kUnits, [&](double unit) { return is_near(ratio, unit); });
}

/// Of a scanner: 1 if it moves in the direction of its mirror image, along twice the yaw of its mounting; −1 if it
/// moves forwards or backwards, and its mirror image would not; 0 if neither is clear.
int mirror_evidence(const Case& c, const MotionAgreement& motion, std::size_t scanner) {
  constexpr double kAlong = 5.0 * kDegree;
  constexpr double kBeside = 10.0 * kDegree;
  if (scanner >= motion.mountings.size()) return 0;
  const MountingFit& mounting = motion.mountings[scanner];
  const Eigen::Quaterniond& q = c.sensor(scanner).T_base_sensor.q;
  const bool is_upright = (q * Eigen::Vector3d::UnitZ()).z() > 0.9;
  if (!mounting.is_known || !is_upright || mounting.angle_sigma > 0.5 * kAlong) return 0;
  const double off_image = std::abs(so3::wrap(mounting.angle - 2.0 * so3::yaw(q)));
  const double off_axis =
      std::min(std::abs(so3::wrap(mounting.angle)), std::abs(so3::wrap(mounting.angle - std::numbers::pi)));
  if (off_image < kAlong && off_axis > kBeside) return 1;
  return off_axis < kAlong && off_image > kBeside ? -1 : 0;
}

bool has_mirrored_scanner(const Case& c, const MotionAgreement& motion) {
  for (std::size_t i = 0; i < motion.mountings.size(); ++i) {
    if (mirror_evidence(c, motion, i) > 0) return true;
  }
  return false;
}

/// Of a scanner that moves backwards: 1 if it finds its own lever arm (it is turned round), −1 if it finds the reversed
/// one (the wheels count backwards), 0 if neither is clear.
int lever_evidence(const Case& c, const MotionAgreement& motion) {
  for (std::size_t i = 0; i < motion.mountings.size(); ++i) {
    const MountingFit& mounting = motion.mountings[i];
    const Eigen::Vector2d lever = c.sensor(i).T_base_sensor.p.head<2>();
    if (!mounting.is_known || lever.norm() < 0.02 || mirror_evidence(c, motion, i) > 0) continue;
    const double shown = mounting.lever.dot(lever) / lever.norm();
    if (std::abs(shown) > 4.0 * mounting.lever_sigma.maxCoeff()) return shown > 0.0 ? 1 : -1;
  }
  return 0;
}

}  // namespace

double cost_of_yaw(const Case& c, const MotionAgreement& motion, std::size_t i, const Ratio& ratio,
                   const Scales& scales) {
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
      if (const int mirror = mirrored ? mirror_evidence(c, motion, i) : 0; mirror != 0)
        return mirror > 0 ? kTelling : kUnlikely;
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
      if (ratio.value < 0.0 && (lever_evidence(c, motion) > 0 || has_mirrored_scanner(c, motion))) return kUnlikely;
      if (is_one_scale(sensor, scales)) return kTelling;
      if (sensor.usual.yaw_scales_with_speed && turns_fit) return kUnlikely;
      // Ways that are reversed while turns are right: a scanner that is turned round makes the same, and more often.
      return ratio.value < 0.0 && turns_fit ? 1.5 * kUsual : kUsual;
    case Role::scanner:
      if (ratio.value > 0.0) return is_near(ratio.value, 1000.0) || is_near(ratio.value, 0.001) ? kTelling : kUsual;
      if (mirror_evidence(c, motion, observer.sensor) > 0) return 0.0;
      if (const int lever = lever_evidence(c, motion); lever != 0) return lever > 0 ? 0.0 : kUnlikely;
      return sensor.steps_backwards ? kTelling : kUsual;
    case Role::fix:
      if (observer.kind == Observer::Kind::course) return is_speed_unit(ratio.value) ? kUsual : kUnlikely;
      // Positions on a map of their own; degrees have no other unit.
      if (std::isnan(sensor.latitude_deg) && is_length_unit(ratio.value)) return kUsual;
      return kUnlikely;
    default:
      break;
  }
  return kUsual;
}

}  // namespace waymark::host::diagnosis
