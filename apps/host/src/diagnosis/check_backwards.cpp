// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "checks.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::host::diagnosis {

namespace {

using Certainty = Finding::Certainty;

constexpr double kTolerance = 30.0 * kDegree;  // about forwards and backwards
constexpr double kSigmas = 4.0;
constexpr long kLeastSamples = 100;

bool is_forwards(const Angle& angle) { return std::abs(so3::wrap(angle.value)) < kTolerance + angle.sigma; }

bool is_backwards(const Angle& angle) {
  return std::abs(so3::wrap(angle.value)) > std::numbers::pi - kTolerance - angle.sigma;
}

bool is_known(const std::optional<Angle>& angle) { return angle && kSigmas * angle->sigma < 0.5 * std::numbers::pi; }

/// True if the trusted way is that of one sensor, whose turns do not show whether it is reversed: those of wheels do.
bool may_be_reversed(const Case& c, const MotionAgreement& motion, const Observer& way) {
  if (way.is_unsigned || c.sensor(way.sensor).usual.yaw_scales_with_speed) return false;
  for (std::size_t i = 0; i < motion.way.observers.size(); ++i) {
    const Observer& other = motion.way.observers[i];
    if (motion.way.is_trusted(i) && !other.is_unsigned && other.sensor != way.sensor) return false;
  }
  return true;
}

/// Who sees the robot move along the way, and who against it.
struct Witnesses {
  std::vector<std::size_t> along;
  std::vector<std::size_t> against;
  bool decides = false;  ///< the positions show that one of these is right
};

/// Specific forces against accelerations, and headings against positions, along which a robot moves forwards most of
/// the time: a heading that they confirm is right, and one that they oppose is turned itself.
Witnesses witnesses_of(const Case& c, const MotionAgreement& motion, std::size_t way) {
  Witnesses witnesses;
  for (std::size_t i = 0; i < c.watch.sensors().size(); ++i) {
    const WatchedSensor& sensor = c.sensor(i);
    if (i == way || c.is_concerned(i)) continue;
    std::vector<Angle> angles;
    if (sensor.force.samples() >= kLeastSamples) {
      if (const auto angle = beside_acceleration(c, motion, i); is_known(angle)) angles.push_back(*angle);
    }
    bool is_right = false;
    if (sensor.has_heading || sensor.heading.samples() > 0) {
      const auto by_positions = positions_beside_heading(c, i);
      if (is_known(by_positions) && is_backwards(*by_positions)) continue;
      is_right = is_known(by_positions) && is_forwards(*by_positions);
      if (const auto angle = beside_heading(c, motion, i); is_known(angle)) angles.push_back(*angle);
    }
    if (std::ranges::any_of(angles, is_forwards)) {
      witnesses.along.push_back(i);
    } else if (std::ranges::any_of(angles, is_backwards)) {
      witnesses.against.push_back(i);
      witnesses.decides = witnesses.decides || is_right;
    }
  }
  return witnesses;
}

}  // namespace

void check_backwards(Case& c, const MotionAgreement& motion) {
  const Observer* way = motion.way.trusted_track();
  if (way == nullptr || c.is_concerned(way->sensor) || !may_be_reversed(c, motion, *way)) return;
  const Witnesses witnesses = witnesses_of(c, motion, way->sensor);
  // If one of them sees it move forwards, who does not is turned himself: that is for the other checks.
  if (witnesses.against.empty() || !witnesses.along.empty()) return;
  const WatchedSensor& sensor = c.sensor(way->sensor);
  const bool is_open = witnesses.against.size() == 1 && !witnesses.decides;
  std::vector<std::string> others;
  std::vector<std::size_t> suspects{way->sensor};
  for (const std::size_t other : witnesses.against) {
    others.push_back(c.sensor(other).name);
    if (is_open) suspects.push_back(other);
  }
  std::string change = fmt::format("source: the sign of the speed of {}", sensor.name);
  if (is_open)
    change += fmt::format("; or sensors.{}.base_T_sensor.yaw_deg, which would be half a turn off", others.front());
  c.add(
      is_open ? Certainty::one_of : Certainty::named, "way", suspects,
      fmt::format("{}it drives backwards where {} forwards", is_open ? sensor.name + ": " : "",
                  others.size() == 1 ? others.front() + " moves" : fmt::format("{} move", fmt::join(others, " and "))),
      change, 0.0);
}

}  // namespace waymark::host::diagnosis
