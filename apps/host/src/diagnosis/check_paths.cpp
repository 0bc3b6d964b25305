// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "checks.hpp"
#include "path_fit.hpp"

namespace waymark::host::diagnosis {

namespace {

using Certainty = Finding::Certainty;

constexpr double kLeastLagSigma = 0.1;  // [s]

/// The other sensors that measure turns and are trusted.
std::vector<std::size_t> who_turns(const MotionAgreement& motion, std::size_t except) {
  std::vector<std::size_t> sensors;
  for (std::size_t i = 0; i < motion.yaw.observers.size(); ++i) {
    const Observer& observer = motion.yaw.observers[i];
    if (observer.sensor == except || !motion.yaw.is_trusted(i) || is_of_path(observer)) continue;
    if (std::ranges::find(sensors, observer.sensor) == sensors.end()) sensors.push_back(observer.sensor);
  }
  return sensors;
}

void add_mirrored(Case& c, const MotionAgreement& motion, std::size_t receiver, const PathFit::Gain& gain) {
  const WatchedSensor& sensor = c.sensor(receiver);
  std::vector<std::size_t> others = who_turns(motion, receiver);
  const bool is_outvoted = others.size() > 1;
  std::vector<std::size_t> suspects{receiver};
  if (!is_outvoted) suspects.insert(suspects.end(), others.begin(), others.end());
  const bool is_open = suspects.size() > 1;
  c.add(is_open ? Certainty::one_of : Certainty::named, "mirrored", suspects,
        fmt::format("{}its positions go round the other way than the turns of {}: mirrored, their path fits",
                    is_open ? sensor.name + ": " : "", c.sensor(others.empty() ? receiver : others.front()).name),
        fmt::format(
            "source: east and north (latitude and longitude) of {} are swapped, or one of them has the other sign{}",
            sensor.name, is_open ? "; or the sign of " + c.sensor(others.front()).name : ""),
        gain.sigmas);
}

void add_late(Case& c, const MotionAgreement& motion, std::size_t receiver, const Lag& lag) {
  const WatchedSensor& sensor = c.sensor(receiver);
  const std::vector<std::size_t> others = who_turns(motion, receiver);
  const auto [behind, why] = shift_of_clock(lag.value);
  c.add(Certainty::named, "delay", {receiver},
        fmt::format("its positions are {:.1f} ± {:.1f} s {} the path of {}{}", std::abs(behind), lag.sigma,
                    behind > 0.0 ? "behind" : "ahead of", others.empty() ? "the others" : c.sensor(others.front()).name,
                    why),
        fmt::format("sensors.{}.delay_s: {:.2f} fits", sensor.name, to_seconds(sensor.delay) + behind),
        std::abs(lag.value) / std::max(lag.sigma, kLeastLagSigma));
}

/// Others that measure turns, all of which agree; nobody if they do not.
std::vector<const Observer*> turning_alike(const Case& c, const Agreement& yaw, std::size_t receiver) {
  std::vector<const Observer*> alike;
  int group = -1;
  for (std::size_t i = 0; i < yaw.observers.size(); ++i) {
    const Observer& observer = yaw.observers[i];
    if (observer.sensor == receiver || observer.kind != Observer::Kind::measured || c.is_concerned(observer.sensor))
      continue;
    if (!alike.empty() && yaw.groups[i] != group) return {};
    group = yaw.groups[i];
    alike.push_back(&observer);
  }
  std::ranges::stable_sort(alike, {}, &Observer::usual_sigma);
  return alike;
}

/// Without wheels: the way is the receiver's own, as late as its positions, and the turns are those of others.
void check_path_without_wheels(Case& c, const MotionAgreement& motion, std::size_t receiver) {
  const WatchedSensor& sensor = c.sensor(receiver);
  const std::vector<const Observer*> turns = turning_alike(c, motion.yaw, receiver);
  if (turns.empty() || sensor.ground_way.samples() == 0) return;
  const PathFit path(sensor, *turns.front()->track, sensor.ground_way, PathFit::WayOf::receiver);
  const auto late = path.is_known() ? path.late() : std::nullopt;
  if (!late) return;
  const auto [behind, why] = shift_of_clock(late->value);
  const WatchedSensor& other = c.sensor(turns.front()->sensor);
  // With one other sensor alone it may be the clock of that one, unless it is a receiver's mistake.
  const bool is_open = turns.size() < 2 && why.empty();
  std::string change = fmt::format("sensors.{}.delay_s: {:.2f} fits", sensor.name, to_seconds(sensor.delay) + behind);
  if (is_open) change += fmt::format("; or sensors.{}.delay_s: {:.2f}", other.name, to_seconds(other.delay) - behind);
  c.add(is_open ? Certainty::one_of : Certainty::named, "delay",
        is_open ? std::vector{receiver, turns.front()->sensor} : std::vector{receiver},
        fmt::format("{}its path is {:.1f} ± {:.1f} s {} the turns of {}{}", is_open ? sensor.name + ": " : "",
                    std::abs(behind), late->sigma, behind > 0.0 ? "behind" : "ahead of", other.name, why),
        change, std::abs(late->value) / std::max(late->sigma, kLeastLagSigma));
}

/// Trusted turns and ways of sensors that no finding concerns.
struct Reckoned {
  const Observer* turns = nullptr;
  const Observer* way = nullptr;

  explicit operator bool() const { return turns != nullptr && way != nullptr; }
};

Reckoned reckoned(const Case& c, const MotionAgreement& motion) {
  const Observer* turns = motion.yaw.trusted_track();
  const Observer* way = motion.way.trusted_track();
  const bool is_usable = turns != nullptr && way != nullptr && !way->is_unsigned && !c.is_concerned(turns->sensor) &&
                         !c.is_concerned(way->sensor);
  return is_usable ? Reckoned{turns, way} : Reckoned{};
}

}  // namespace

std::optional<Angle> beside_path(const Case& c, const MotionAgreement& motion, std::size_t receiver,
                                 const Track& heading) {
  const Reckoned by = reckoned(c, motion);
  if (!by || c.is_concerned(receiver)) return std::nullopt;
  return PathFit(c.sensor(receiver), *by.turns->track, way_of(c, *by.way)).beside(heading);
}

void check_paths(Case& c, const MotionAgreement& motion) {
  for (std::size_t i = 0; i < c.watch.sensors().size(); ++i) {
    if (measured_way(c.watch) != nullptr || c.sensor(i).fixes.empty() || c.is_concerned(i)) continue;
    check_path_without_wheels(c, motion, i);
  }
  const Reckoned by = reckoned(c, motion);
  if (!by) return;
  for (std::size_t i = 0; i < c.watch.sensors().size(); ++i) {
    const WatchedSensor& sensor = c.sensor(i);
    if (sensor.fixes.empty() || c.is_concerned(i) || i == by.turns->sensor || i == by.way->sensor) continue;
    const PathFit path(sensor, *by.turns->track, way_of(c, *by.way));
    if (!path.is_known()) continue;
    const PathFit::Gain mirrored = path.mirrored();
    if (mirrored.is_clear()) {
      add_mirrored(c, motion, i, mirrored);
    } else if (const auto late = path.late()) {
      add_late(c, motion, i, *late);
    }
  }
}

}  // namespace waymark::host::diagnosis
