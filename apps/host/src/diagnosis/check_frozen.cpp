// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <string_view>

#include "checks.hpp"

namespace waymark::host::diagnosis {

namespace {

using Certainty = Finding::Certainty;

constexpr double kFarther = 8.0;         // [m] driven with one position: far beyond what a receiver rounds to
constexpr double kTurned = 0.8;          // [rad] turned with one heading
constexpr double kLongest = 20.0;        // [s]
constexpr double kStep = 0.5;            // [s]
constexpr double kNoChange = 1e-9;       // [rad]
constexpr double kMissed = 0.4;          // [rad] turned by others and not by a rate that stays the same
constexpr double kLongestHeight = 60.0;  // [s]
constexpr double kClimbed = 5.0;         // [m] climbed with one height

/// Positions that stay exactly the same while the robot drives; `driver`: who measures that.
bool check_position(Case& c, std::size_t i, const Track& way, std::string_view driver) {
  const std::vector<Fix>& fixes = c.sensor(i).fixes;
  std::size_t from = 0;
  for (std::size_t k = 1; k < fixes.size(); ++k) {
    if (fixes[k].p != fixes[from].p) {
      from = k;
      continue;
    }
    const auto driven = way.change(fixes[from].t, fixes[k].t);
    if (!driven || std::abs(*driven) < kFarther) continue;
    c.add(
        Certainty::named, "frozen", {i},
        fmt::format("its position stays the same to the last digit for {:.0f} s, in which {} {:.0f} m",
                    fixes[k].t - fixes[from].t, driver, std::abs(*driven)),
        fmt::format("source: {} repeats an old fix; the receiver, its driver or a column of the log", c.sensor(i).name),
        0.0);
    return true;
  }
  return false;
}

/// True if the track changes by the same amount in each step.
bool is_steady(const Track& track, double from, double to) {
  const auto first = track.change(from, from + kStep);
  if (!first) return false;
  for (double t = from; t + kStep <= to; t += kStep) {
    const auto change = track.change(t, t + kStep);
    if (!change || std::abs(*change - *first) > kNoChange) return false;
  }
  return true;
}

/// How far the lowest and the highest of some heights are from each other, each a mean over a sixth of the time: single
/// ones are noisy.
std::optional<double> climb(const Track& height, double from, double to) {
  constexpr double kEvery = 1.0;  // [s]
  constexpr int kParts = 6;
  const double length = (to - from) / kParts;
  double lowest = std::numeric_limits<double>::infinity();
  double highest = -lowest;
  for (int part = 0; part < kParts; ++part) {
    double sum = 0.0;
    for (double t = 0.0; t < length; t += kEvery) {
      const auto change = height.change(from, from + part * length + t);
      if (!change) return std::nullopt;
      sum += *change;
    }
    lowest = std::min(lowest, sum / std::ceil(length / kEvery));
    highest = std::max(highest, sum / std::ceil(length / kEvery));
  }
  return highest - lowest;
}

/// Heights that stay exactly the same while another sensor climbs.
void check_height(Case& c, std::size_t i) {
  const WatchedSensor& sensor = c.sensor(i);
  if (!std::isfinite(sensor.usual.height_m) || c.is_blamed(i)) return;
  for (const WatchedSensor& other : c.watch.sensors()) {
    if (&other == &sensor || other.height.samples() == 0) continue;
    for (double from = 0.0; from + kLongestHeight <= c.watch.newest(); from += kLongest) {
      const auto own = sensor.height.change(from, from + kLongestHeight);
      const auto climbed = climb(other.height, from, from + kLongestHeight);
      if (!own || *own != 0.0 || !climbed || *climbed < kClimbed) continue;
      if (!other.is_altimeter() && !exceeds_wander(other, *climbed)) continue;
      if (!is_steady(sensor.height, from, from + kLongestHeight)) continue;
      c.add(Certainty::named, "frozen", {i},
            fmt::format("its height stays the same to the last digit for {:.0f} s, in which {} changes by {:.0f} m",
                        kLongestHeight, other.name, *climbed),
            fmt::format("source: {} repeats an old height; the device, its driver or a column of the log", sensor.name),
            0.0);
      return;
    }
  }
}

/// True if the height changed in most steps before.
bool changes_before(const Track& height, double end) {
  constexpr long kLeastSteps = 40;
  long changed = 0;
  long known = 0;
  for (double t = 0.0; t + kStep <= end; t += kStep) {
    const auto change = height.change(t, t + kStep);
    if (!change) continue;
    ++known;
    if (*change != 0.0) ++changed;
  }
  return known >= kLeastSteps && 2 * changed > known;
}

/// Heights that stay exactly the same while the robot drives, and changed from one to the next before.
void check_height_is_alive(Case& c, std::size_t i, const Track& way) {
  const WatchedSensor& sensor = c.sensor(i);
  if (!sensor.is_altimeter() || c.is_blamed(i)) return;
  for (double from = 0.0; from + kLongestHeight <= c.watch.newest(); from += kLongest) {
    const double to = from + kLongestHeight;
    const auto own = sensor.height.change(from, to);
    const auto driven = way.change(from, to);
    if (!own || *own != 0.0 || !driven || std::abs(*driven) < kFarther) continue;
    if (!is_steady(sensor.height, from, to) || !changes_before(sensor.height, from)) continue;
    c.add(
        Certainty::named, "frozen", {i},
        fmt::format("its height stays the same to the last digit for {:.0f} s, in which the wheels drive {:.0f} m, and "
                    "changed all the time before",
                    kLongestHeight, std::abs(*driven)),
        fmt::format("source: {} repeats an old height; the device, its driver or a column of the log", sensor.name),
        0.0);
    return;
  }
}

/// A heading is frozen if it stays, a rate if it stays at what is not zero: a robot that stands has no rate, whatever a
/// raw gyro has beside it.
bool is_frozen(const WatchedSensor& sensor, double from, double to, double turned) {
  if (!is_steady(sensor.yaw, from, to)) return false;
  const double own = *sensor.yaw.change(from, to);
  const bool stays = std::abs(own) < kNoChange;
  return sensor.has_heading ? stays : !stays && std::abs(turned - own) > kMissed;
}

/// A heading, or a rate, that stays exactly the same while another sensor turns.
void check_turns_are_alive(Case& c, std::size_t i) {
  const WatchedSensor& sensor = c.sensor(i);
  if (sensor.yaw.samples() == 0 || c.is_blamed(i)) return;  // such as a rate that is zero throughout
  const char* const quantity = sensor.has_heading ? "heading" : "yaw rate";
  for (const WatchedSensor& other : c.watch.sensors()) {
    if (&other == &sensor || other.yaw.samples() == 0) continue;
    for (double from = 0.0; from + kLongest <= c.watch.newest(); from += kLongest) {
      const auto turned = other.yaw.change(from, from + kLongest);
      if (!turned || std::abs(*turned) < kTurned || !is_frozen(sensor, from, from + kLongest, *turned)) continue;
      c.add(Certainty::named, "frozen", {i},
            fmt::format("its {} stays the same to the last digit for {:.0f} s, in which {} turns by {:.0f} degrees",
                        quantity, kLongest, other.name, std::abs(*turned) / kDegree),
            fmt::format("source: {} repeats an old {}; the device, its driver or a column of the log", sensor.name,
                        quantity),
            0.0);
      return;
    }
  }
}

/// True if the turn per way stays exactly the same, while the robot drives.
bool is_curvature_steady(const WatchedSensor& sensor, double from, double to) {
  constexpr double kLeastStep = 0.2;  // [m] of a step
  constexpr double kRounding = 1e-6;  // [rad/m]
  std::optional<double> first;
  double driven = 0.0;
  for (double t = from; t + kStep <= to; t += kStep) {
    const auto way = sensor.way.change(t, t + kStep);
    const auto turn = sensor.yaw.change(t, t + kStep);
    if (!way || !turn) return false;
    if (std::abs(*way) < kLeastStep) continue;
    driven += std::abs(*way);
    const double curvature = *turn / *way;
    if (!first) first = curvature;
    if (std::abs(curvature - *first) > kRounding) return false;
  }
  return driven > kFarther;
}

/// A steering angle that stays exactly the same while another sensor turns now more, now less than it shows.
void check_steering_is_alive(Case& c, std::size_t i) {
  constexpr int kParts = 4;
  const WatchedSensor& sensor = c.sensor(i);
  if (!sensor.usual.yaw_scales_with_speed || sensor.yaw.samples() == 0 || c.is_blamed(i)) return;
  for (const WatchedSensor& other : c.watch.sensors()) {
    if (&other == &sensor || other.yaw.samples() == 0) continue;
    for (double from = 0.0; from + kLongest <= c.watch.newest(); from += 0.25 * kLongest) {
      if (!is_curvature_steady(sensor, from, from + kLongest)) continue;
      double least = std::numeric_limits<double>::infinity();
      double most = -least;
      for (int part = 0; part < kParts; ++part) {
        const double begin = from + part * kLongest / kParts;
        const auto own = sensor.yaw.change(begin, begin + kLongest / kParts);
        const auto turned = other.yaw.change(begin, begin + kLongest / kParts);
        if (!own || !turned) continue;
        least = std::min(least, *turned - *own);
        most = std::max(most, *turned - *own);
      }
      if (most - least < kMissed) continue;
      c.add(Certainty::named, "frozen", {i},
            fmt::format("its turn per way stays the same to the last digit for {:.0f} s, in which {} turns otherwise",
                        kLongest, other.name),
            fmt::format("source: {} repeats an old steering angle; the device, its driver or a column of the log",
                        sensor.name),
            0.0);
      return;
    }
  }
}

}  // namespace

void check_frozen(Case& c) {
  const Track* way = measured_way(c.watch);
  const bool is_spatial = c.robot.settings.motion == StateLayout::Motion::spatial;
  for (std::size_t i = 0; i < c.watch.sensors().size(); ++i) {
    const WatchedSensor& sensor = c.sensor(i);
    const bool is_found = way != nullptr && check_position(c, i, *way, "the wheels drive");
    if (!is_found && sensor.ground_way.samples() > 0)
      check_position(c, i, sensor.ground_way, "its velocity sums up to");
    check_turns_are_alive(c, i);
    check_steering_is_alive(c, i);
    if (!is_spatial) continue;
    check_height(c, i);
    if (way != nullptr) check_height_is_alive(c, i, *way);
  }
}

}  // namespace waymark::host::diagnosis
