// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "checks.hpp"

namespace waymark::host::diagnosis {

namespace {

constexpr double kFarthest = 60.0;  // [s]
constexpr double kStep = 0.25;      // [s]
constexpr double kSpan = 1.0;       // [s]
constexpr double kNear = 1.5;       // [s]: smaller delays are the business of check_delays
constexpr double kClear = 0.7;      // correlation of turns that are the same ones
constexpr double kUnlike = 0.75;    // of others by that of the best, at most
constexpr std::size_t kLeastSpans = 40;

/// Turns of two sensors that are the same ones at another time.
struct Shift {
  std::size_t sensor;
  std::size_t against;
  double behind;  ///< of `sensor` [s]
};

/// Correlation of the spans with the track's changes, if the spans' times are `behind` those of the track.
std::optional<double> correlation(const std::vector<Span>& spans, const Track& track, double behind) {
  double n = 0.0, a = 0.0, b = 0.0, aa = 0.0, bb = 0.0, ab = 0.0;
  for (const Span& span : spans) {
    const auto change = track.change(span.from - behind, span.to - behind);
    if (!change) continue;
    n += 1.0;
    a += span.value;
    b += *change;
    aa += span.value * span.value;
    bb += *change * *change;
    ab += span.value * *change;
  }
  const double of_a = n * aa - a * a;
  const double of_b = n * bb - b * b;
  if (n < static_cast<double>(kLeastSpans) || !(of_a > 0.0) || !(of_b > 0.0)) return {};
  return (n * ab - a * b) / std::sqrt(of_a * of_b);
}

/// The one shift at which turns that have nothing to do with each other are the same.
std::optional<double> find_shift(const std::vector<Span>& spans, const Track& track) {
  struct Tried {
    double behind;
    double correlation;
  };
  std::vector<Tried> tried;
  if (spans.size() < kLeastSpans) return {};
  for (double behind = -kFarthest; behind <= kFarthest; behind += kStep) {
    if (const auto r = correlation(spans, track, behind)) tried.push_back({behind, *r});
  }
  if (tried.empty()) return {};
  const Tried best = *std::ranges::max_element(tried, {}, &Tried::correlation);
  const bool is_only_one = std::ranges::all_of(tried, [&](const Tried& other) {
    return std::abs(other.behind - best.behind) <= 2.0 * kNear || other.correlation < kUnlike * best.correlation;
  });
  if (best.correlation < kClear || std::abs(best.behind) < kNear || !is_only_one) return {};
  return best.behind;
}

/// True if a sensor that measures turns is known to be wrong: from which fix to which the positions drive straight on
/// is known by the turns of all (observers.cpp).
bool are_chords_wrong(const Case& c) {
  for (std::size_t i = 0; i < c.watch.sensors().size(); ++i) {
    if (c.sensor(i).yaw.samples() > 0 && c.is_blamed(i, "way")) return true;
  }
  return false;
}

std::vector<Shift> find_shifts(const Case& c, const Agreement& yaw) {
  std::vector<Shift> shifts;
  const bool has_chords = !are_chords_wrong(c);
  const auto are_known = [&](std::size_t one, std::size_t other) {
    return std::ranges::any_of(shifts, [&](const Shift& shift) {
      return (shift.sensor == one && shift.against == other) || (shift.sensor == other && shift.against == one);
    });
  };
  for (std::size_t i = 0; i < yaw.observers.size(); ++i) {
    for (std::size_t j = 0; j < yaw.observers.size(); ++j) {
      const Observer& one = yaw.observers[i];
      if (one.kind == Observer::Kind::chord && !has_chords) continue;
      const Observer& other = yaw.observers[j];
      // Of two tracks once, as the turns are compared (compare_motion.cpp).
      if (i == j || other.track == nullptr || (one.track != nullptr && j < i)) continue;
      const Ratio::Verdict verdict = yaw.ratios[i][j].verdict;
      const bool may_be_shifted =
          (verdict == Ratio::Verdict::unrelated || verdict == Ratio::Verdict::unknown) && !yaw.ratios[i][j].is_forgiven;
      if (one.sensor == other.sensor || are_known(one.sensor, other.sensor) || !may_be_shifted) continue;
      const std::vector<Span> spans = one.track != nullptr ? spans_of(*one.track, kSpan, c.watch.newest()) : one.spans;
      if (const auto behind = find_shift(spans, *other.track)) shifts.push_back({one.sensor, other.sensor, *behind});
    }
  }
  return shifts;
}

/// Of each sensor: 0 or 1, those of one number have one clock; -1: no shift was found to any.
std::vector<int> clocks_of(std::size_t sensors, const std::vector<Shift>& shifts) {
  std::vector<int> clocks(sensors, -1);
  clocks[shifts.front().sensor] = 0;
  for (std::size_t round = 0; round < shifts.size(); ++round) {
    for (const Shift& shift : shifts) {
      if (clocks[shift.sensor] >= 0) clocks[shift.against] = 1 - clocks[shift.sensor];
      if (clocks[shift.against] >= 0) clocks[shift.sensor] = 1 - clocks[shift.against];
    }
  }
  return clocks;
}

/// A receiver, or the heading of one, has a clock of its own.
bool is_of_receiver(const WatchedSensor& sensor) {
  return sensor.role() == Role::fix || sensor.role() == Role::heading;
}

/// True if a sensor turns at the same times as one that has no part in the shifts.
bool has_the_time_of_others(const Agreement& yaw, std::size_t sensor, const std::vector<int>& clocks) {
  for (std::size_t i = 0; i < yaw.observers.size(); ++i) {
    for (std::size_t j = 0; j < yaw.observers.size(); ++j) {
      const Ratio& ratio = yaw.ratios[i][j];
      const bool is_third = yaw.observers[i].sensor == sensor && clocks[yaw.observers[j].sensor] < 0;
      if (is_third && ratio.verdict == Ratio::Verdict::agree && std::abs(ratio.shift) < kSpan) return true;
    }
  }
  return false;
}

}  // namespace

ClockShift shift_of_clock(double behind) {
  constexpr double kLeapSeconds = 18.0;  // by which the clock of GPS is ahead of UTC since 2017
  if (std::abs(std::abs(behind) - kLeapSeconds) >= 0.6) return {behind, ""};
  return {std::copysign(kLeapSeconds, behind), ": the leap seconds between the clock of GPS and UTC"};
}

void check_shifted_clocks(Case& c, const Agreement& yaw) {
  const std::vector<Shift> shifts = find_shifts(c, yaw);
  if (shifts.empty()) return;
  const std::vector<int> clocks = clocks_of(c.watch.sensors().size(), shifts);
  // The clock of fewer sensors is wrong; of as many, that of the receivers.
  double balance = 0.0;
  for (std::size_t i = 0; i < clocks.size(); ++i) {
    if (clocks[i] >= 0) balance += (clocks[i] == 0 ? 1.0 : -1.0) * (is_of_receiver(c.sensor(i)) ? 0.9 : 1.0);
  }
  const int wrong = balance > 0.0 ? 1 : 0;
  for (std::size_t i = 0; i < clocks.size(); ++i) {
    if (clocks[i] != wrong || c.is_blamed(i) || has_the_time_of_others(yaw, i, clocks)) continue;
    std::vector<std::string> others;
    double behind = 0.0;
    for (const Shift& shift : shifts) {
      if (shift.sensor != i && shift.against != i) continue;
      behind = shift.sensor == i ? shift.behind : -shift.behind;
      others.push_back(c.sensor(shift.sensor == i ? shift.against : shift.sensor).name);
    }
    const WatchedSensor& sensor = c.sensor(i);
    const auto [shift, why] = shift_of_clock(behind);
    c.add(Finding::Certainty::named, "delay", {i},
          fmt::format("its stamps are {:.1f} s {} those of {}{}", std::abs(shift), shift > 0.0 ? "behind" : "ahead of",
                      fmt::join(others, ", "), why),
          fmt::format("sensors.{}.delay_s: {:.2f} fits", sensor.name, to_seconds(sensor.delay) + shift), 0.0);
  }
}

}  // namespace waymark::host::diagnosis
