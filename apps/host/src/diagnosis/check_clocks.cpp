// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "checks.hpp"

namespace waymark::host::diagnosis {

namespace {

using Certainty = Finding::Certainty;

constexpr double kApart = 60.0;          // [s] between the stamps of two clocks that have nothing in common
constexpr double kQuarterHour = 900.0;   // [s]: time zones are whole multiples
constexpr double kStartsWithin = 120.0;  // [s] of the others
constexpr double kLeastLog = 10.0;       // [s]
constexpr double kLeastSilence = 20.0;   // [s] at the end
constexpr double kSilentShare = 0.1;     // of the log
constexpr double kOutageShare = 0.4;     // of a receiver, which may be under trees for long
constexpr double kSilentIntervals = 10.0;

/// From the last stamp of the earlier one to the first stamp of the later one [s]; ≤ 0 if they overlap.
double apart(const WatchedSensor& a, const WatchedSensor& b) {
  return std::max(to_seconds(*b.first_stamp - *a.last_stamp), to_seconds(*a.first_stamp - *b.last_stamp));
}

/// Those whose stamps overlap with those of the sensor, itself among them.
std::vector<std::size_t> beside(const Case& c, std::size_t i) {
  std::vector<std::size_t> found;
  for (std::size_t k = 0; k < c.watch.sensors().size(); ++k) {
    if (c.sensor(k).first_stamp && apart(c.sensor(i), c.sensor(k)) < kApart) found.push_back(k);
  }
  return found;
}

void check_silent(Case& c, std::size_t i, double length) {
  if (c.sensor(i).first_stamp || length < kLeastLog) return;
  c.add(Certainty::named, "no data", {i}, fmt::format("no measurement in {:.0f} s of log", length),
        fmt::format("source: nothing is delivered as {}; sensors.{}.enabled: false if the robot has none",
                    c.sensor(i).name, c.sensor(i).name),
        0.0);
}

/// A sensor that delivers nothing any more, long before the others end. `end`: the last stamp of all.
void check_end(Case& c, std::size_t i, double length, Time end) {
  const WatchedSensor& sensor = c.sensor(i);
  if (!sensor.first_stamp || beside(c, i).size() < 2) return;
  // Of wrong stamps more is known, and less of their end.
  const auto is_of_stamps = [](const Finding& f) { return f.check == "stamps" || f.check == "clock"; };
  if (std::ranges::any_of(c.findings, is_of_stamps)) return;
  const double silent = to_seconds(end - *sensor.last_stamp);
  const double share = sensor.role() == Role::fix ? kOutageShare : kSilentShare;
  if (silent < std::max({kLeastSilence, share * length, kSilentIntervals * sensor.intervals.quantile(0.99)})) return;
  c.add(Certainty::named, "no data", {i},
        fmt::format("no measurement in the last {:.0f} of {:.0f} s of log", silent, length),
        fmt::format("source: {} ends early: the device, its cable or its file", sensor.name), 0.0);
}

/// A sensor that shares no time with any other one, where others do with each other.
void check_clock(Case& c, std::size_t i) {
  if (!c.sensor(i).first_stamp || beside(c, i).size() > 1) return;
  std::vector<std::size_t> others;
  for (std::size_t k = 0; k < c.watch.sensors().size(); ++k) {
    if (k == i || !c.sensor(k).first_stamp) continue;
    if (const std::vector<std::size_t> group = beside(c, k); group.size() > others.size()) others = group;
  }
  if (others.empty()) return;
  const bool is_open = others.size() == 1;
  if (is_open && i > others.front()) return;  // one finding for both
  const double offset = to_seconds(*c.sensor(i).first_stamp - *c.sensor(others.front()).first_stamp);
  const double zone = kQuarterHour * std::round(offset / kQuarterHour);
  const double fits = std::abs(offset - zone) < kStartsWithin ? zone : offset;
  std::vector<std::size_t> suspects{i};
  if (is_open) suspects.push_back(others.front());
  c.add(is_open ? Certainty::one_of : Certainty::named, "clock", suspects,
        fmt::format("{}its stamps begin {:.0f} s {} those of {} and have no time in common with them: another clock or "
                    "time zone",
                    is_open ? c.sensor(i).name + ": " : "", std::abs(offset), offset > 0.0 ? "after" : "before",
                    c.sensor(others.front()).name),
        fmt::format("source: time of {}: {{ offset_s: {:.0f} }}", c.sensor(i).name, -fits), 0.0);
}

}  // namespace

void check_clocks(Case& c) {
  double length = 0.0;
  Time end{};  // of the sensor that delivers longest: a clock of its own may be anywhere
  for (const WatchedSensor& sensor : c.watch.sensors()) {
    if (!sensor.first_stamp) continue;
    const double own = to_seconds(*sensor.last_stamp - *sensor.first_stamp);
    if (own <= length) continue;
    length = own;
    end = *sensor.last_stamp;
  }
  for (std::size_t i = 0; i < c.watch.sensors().size(); ++i) {
    if (!c.sensor(i).is_watched) continue;
    check_silent(c, i, length);
    check_clock(c, i);
    check_end(c, i, length, end);
  }
}

}  // namespace waymark::host::diagnosis
