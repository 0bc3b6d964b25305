// SPDX-License-Identifier: Apache-2.0
#include "motion_advice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "waymark/interface/payloads.hpp"

namespace waymark::host::diagnosis {

namespace {

constexpr double kCertain = 3.0;  ///< σ

std::string plus_minus(const Ratio& ratio) { return fmt::format("{:.3g} ± {:.2g}", ratio.value, ratio.sigma); }

/// Those of a group that an observer is compared with; of its own sensor, what else that observes.
std::string others(const Case& c, const Agreement& agreement, int group, const Observer& of) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < agreement.observers.size(); ++i) {
    const Observer& other = agreement.observers[i];
    if (agreement.groups[i] != group || &other == &of) continue;
    const std::string name = other.sensor != of.sensor              ? c.sensor(other.sensor).name
                             : other.kind == Observer::Kind::course ? "its own velocity"
                                                                    : "its own positions";
    if (std::ranges::find(names, name) == names.end()) names.push_back(name);
  }
  return fmt::format("{}", fmt::join(names, ", "));
}

bool goes_backwards(const WatchedSensor& wheels) {
  const auto end = wheels.way.at(wheels.way.newest());
  return end && *end < 0.0;
}

}  // namespace

std::string change_of_yaw(const Case& c, const Observer& observer, const Ratio& ratio, const Scales& scales) {
  const std::size_t i = observer.sensor;
  const WatchedSensor& sensor = c.sensor(i);
  const std::string& name = sensor.name;
  const double r = ratio.value;
  const bool mirrored = is_near(r, -1.0);
  const bool is_absurd = ratio.verdict == Ratio::Verdict::unrelated || !is_within(std::abs(r), 0.2, 5.0, 1.0);
  const bool is_degrees = is_within(std::abs(r), 1.0 / kDegree, 1.0 / kDegree, 1.35);
  switch (sensor.role()) {
    case Role::wheels:
      if (is_absurd && sensor.payload == WheelSpeeds::kType)
        return fmt::format("source: left_mps and right_mps of {}: the sign, the unit or the column of one of them",
                           name);
      if (is_one_scale(sensor, scales)) return fmt::format("source: speeds of {} times {:.4g}", name, 1.0 / r);
      if (sensor.payload == WheelSpeeds::kType) {
        const double track = c.setting(i, "track_m") * std::abs(r);
        if (r > 0.0) return fmt::format("sensors.{}.track_m: {:.3g} fits", name, track);
        const bool has_other_track = !mirrored && std::abs(std::abs(r) - 1.0) > kCertain * ratio.sigma;
        return fmt::format("source: swap left_mps and right_mps of {} (or both count backwards){}", name,
                           has_other_track ? fmt::format("; sensors.{}.track_m: {:.3g} fits then", name, track) : "");
      }
      if (sensor.payload == WheelSteering::kType) {
        if (mirrored && goes_backwards(sensor))
          return fmt::format("source: speed of {} times -1 (it drives backwards most of the time)", name);
        if (mirrored) return fmt::format("source: steering_rad of {} times -1 (left is positive)", name);
        if (r > 10.0) return fmt::format("source: steering_rad of {} times {:.6f} (degrees)", name, kDegree);
        return fmt::format("sensors.{}.wheelbase_m: {:.3g} fits, or steering_rad times {:.3g}", name,
                           c.setting(i, "wheelbase_m") * r, 1.0 / r);
      }
      if (is_absurd) return fmt::format("source: the rotation of {}: the sign, the unit or the column of it", name);
      return fmt::format("source: rotation of {} times {:.4g}", name, 1.0 / r);
    case Role::gyro:
      if (ratio.verdict == Ratio::Verdict::unrelated || (is_absurd && !is_degrees && !is_near(std::abs(r), kDegree)))
        return fmt::format("sensors.{}.base_T_sensor: another of its axes points up, or its columns are swapped", name);
      if (mirrored) {
        const Eigen::Vector3d z_base = sensor.T_base_sensor.q * Eigen::Vector3d::UnitZ();
        if (std::abs(z_base.z()) < 0.9)
          return fmt::format("source: the opposite sign of the rates of {}, or it is turned over: base_T_sensor", name);
        return fmt::format("sensors.{}.base_T_sensor.roll_deg: {} fits, or the opposite sign of its rates", name,
                           z_base.z() < 0.0 ? 0 : 180);
      }
      if (is_degrees) return fmt::format("source: rates of {} times {:.9f} (degrees per second)", name, kDegree);
      return fmt::format("source: rates of {} times {:.4g}", name, 1.0 / r);
    case Role::heading:
      if (mirrored && sensor.usual.m_base.allFinite())
        return fmt::format("source: m_{}_t and m_{}_t of {}: swapped, or the sign of one of them",
                           axis_along(sensor, Eigen::Vector3d::UnitX()), axis_along(sensor, Eigen::Vector3d::UnitY()),
                           name);
      if (mirrored) return fmt::format("source: heading of {} times -1 (it is clockwise from north)", name);
      return fmt::format("sensors.{}: its heading does not follow the turns", name);
    case Role::scanner:
      if (ratio.verdict == Ratio::Verdict::unrelated)
        return fmt::format("source: the scans of {} do not turn with the robot: repeated ones, or another scanner",
                           name);
      if (!(r < 0.0))
        return fmt::format(
            "source: step_deg of {}, the angle from beam to beam: its scans turn {:.3g} times as far as they should",
            name, r);
      return fmt::format("source: the scans of {} are mirrored: the opposite sign of step_deg (and of start_deg)",
                         name);
    case Role::fix:
      if (mirrored && observer.kind == Observer::Kind::course)
        return fmt::format("source: the course of {} counts the wrong way round: clockwise from north is right", name);
      if (mirrored)
        return fmt::format("source: swap east and north of {}, or the sign of its longitude (east is positive)", name);
      return fmt::format("source: columns, signs and units of {}, and its datum", name);
    case Role::other:
      break;
  }
  return {};
}

std::string change_of_way(const Case& c, const Observer& observer, const Ratio& ratio, const Scales& scales) {
  const WatchedSensor& sensor = c.sensor(observer.sensor);
  const double r = ratio.value;
  if (observer.kind == Observer::Kind::chord) {
    constexpr double kFoot = 0.3048;
    const bool is_feet = is_near(r * kFoot, 1.0);
    return fmt::format("source: positions of {} times {:.4g}{}", sensor.name, is_feet ? kFoot : 1.0 / r,
                       is_feet ? " (feet)" : "");
  }
  if (sensor.role() == Role::scanner) {
    if (r > 0.0) return fmt::format("source: ranges_m of {} times {:.4g}", sensor.name, 1.0 / r);
    // Mirrored scans turn the wrong way, too.
    const bool is_mirrored = scales.yaw ? *scales.yaw < 0.0 : sensor.steps_backwards;
    return is_mirrored
               ? fmt::format("source: the scans of {} are mirrored: the opposite sign of step_deg (and of start_deg)",
                             sensor.name)
               : fmt::format("sensors.{}.base_T_sensor.yaw_deg: 180 more fits", sensor.name);
  }
  if (std::abs(r) < 0.01) return fmt::format("source: speeds of {}: another column, these hardly change", sensor.name);
  if (r < 0.0) return fmt::format("source: speeds of {} times -1", sensor.name);
  return fmt::format("source: speeds of {} times {:.4g}", sensor.name, 1.0 / r);
}

std::string seen_of_yaw(const Case& c, const Agreement& agreement, std::size_t i, int group, const Ratio& ratio) {
  const std::string against = others(c, agreement, group, agreement.observers[i]);
  if (ratio.verdict == Ratio::Verdict::unrelated)
    return fmt::format("its turns have nothing to do with those of {} ({} spans)", against, ratio.spans);
  return fmt::format("it turns {} times as far as {} ({} spans)", plus_minus(ratio), against, ratio.spans);
}

std::string seen_of_way(const Case& c, const Agreement& agreement, std::size_t i, int group, const Ratio& ratio) {
  return fmt::format("its way is {} times that of {} ({} spans)", plus_minus(ratio),
                     others(c, agreement, group, agreement.observers[i]), ratio.spans);
}

}  // namespace waymark::host::diagnosis
