// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <cstddef>

#include "checks.hpp"

namespace waymark::host::diagnosis {

namespace {

using Certainty = Finding::Certainty;

constexpr double kFarther = 8.0;    // [m] driven with one position: far beyond what a receiver rounds to
constexpr double kTurned = 0.8;     // [rad] turned with one heading
constexpr double kLongest = 20.0;   // [s]
constexpr double kStep = 0.5;       // [s]
constexpr double kNoChange = 1e-9;  // [rad]

/// Positions that stay exactly the same while the wheels drive.
void check_position(Case& c, std::size_t i, const Track& way) {
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
        fmt::format("its position stays the same to the last digit for {:.0f} s, in which the wheels drive {:.0f} m",
                    fixes[k].t - fixes[from].t, std::abs(*driven)),
        fmt::format("source: {} repeats an old fix; the receiver, its driver or a column of the log", c.sensor(i).name),
        0.0);
    return;
  }
}

bool is_constant(const Track& track, double from, double to) {
  for (double t = from; t + kStep <= to; t += kStep) {
    const auto change = track.change(t, t + kStep);
    if (!change || std::abs(*change) > kNoChange) return false;
  }
  return true;
}

/// A heading that stays exactly the same while another sensor turns.
void check_heading_is_alive(Case& c, std::size_t i) {
  const WatchedSensor& sensor = c.sensor(i);
  if (!sensor.has_heading) return;
  for (const WatchedSensor& other : c.watch.sensors()) {
    if (&other == &sensor || other.yaw.samples() == 0) continue;
    for (double from = 0.0; from + kLongest <= c.watch.newest(); from += kLongest) {
      const auto turned = other.yaw.change(from, from + kLongest);
      if (!turned || std::abs(*turned) < kTurned || !is_constant(sensor.yaw, from, from + kLongest)) continue;
      c.add(
          Certainty::named, "frozen", {i},
          fmt::format("its heading stays the same to the last digit for {:.0f} s, in which {} turns by {:.0f} degrees",
                      kLongest, other.name, std::abs(*turned) / kDegree),
          fmt::format("source: {} repeats an old heading; the device, its driver or a column of the log", sensor.name),
          0.0);
      return;
    }
  }
}

}  // namespace

void check_frozen(Case& c) {
  const Track* way = measured_way(c.watch);
  for (std::size_t i = 0; i < c.watch.sensors().size(); ++i) {
    if (way != nullptr) check_position(c, i, *way);
    check_heading_is_alive(c, i);
  }
}

}  // namespace waymark::host::diagnosis
