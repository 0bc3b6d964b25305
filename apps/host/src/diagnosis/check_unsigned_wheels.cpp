// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "checks.hpp"
#include "fit.hpp"

namespace waymark::host::diagnosis {

namespace {

constexpr double kSpan = 0.5;        // [s]
constexpr double kLeastTurn = 0.05;  // [rad] of a span
constexpr double kNoise = 0.02;      // [rad] likewise
constexpr double kNear = 0.25;       // of a turn: so far off it is the same
constexpr double kMostOnTheSpot = 0.2;
constexpr double kBackwards = -0.01;  // [m] of a span
constexpr std::size_t kLeastPivots = 5;
constexpr std::size_t kLeastSpans = 10;
constexpr double kLeastShare = 0.2;  // of the turns, that are explained by lost signs alone
constexpr double kWhole = 0.85;      // of the turns, that are explained at all

/// What the wheels show of a span, and how far the robot has turned.
struct Turn {
  double driven;  // [m]
  double shown;   // [rad]
  double turned;  // [rad]
};

/// Nothing of wheels that run backwards at times, which have signs.
std::vector<Turn> turns_of(const WatchedSensor& wheels, const Track& yaw, double newest) {
  std::vector<Turn> turns;
  std::vector<double> differences;
  for (double t = 0.0; t + kSpan <= newest; t += kSpan) {
    const auto driven = wheels.way.change(t, t + kSpan);
    const auto shown = wheels.yaw.change(t, t + kSpan);
    const auto turned = yaw.change(t, t + kSpan);
    if (!driven || !shown || !turned) continue;
    if (*driven < kBackwards) return {};
    turns.push_back({*driven, *shown, *turned});
    if (std::abs(*turned - *shown) < kLeastTurn) differences.push_back(*turned - *shown);
  }
  const double bias = median(differences);
  for (Turn& turn : turns) turn.turned -= bias;
  std::erase_if(turns, [](const Turn& turn) { return std::abs(turn.turned) < kLeastTurn; });
  return turns;
}

/// What the wheels show when they run against each other without their signs: a way, by so much per angle, and no turn.
/// 0 if they hardly ever do.
double turn_per_way_on_the_spot(const std::vector<Turn>& turns) {
  std::vector<double> ratios;
  for (const Turn& turn : turns) {
    if (std::abs(turn.shown) < kMostOnTheSpot * std::abs(turn.turned) && turn.driven > 0.0)
      ratios.push_back(std::abs(turn.turned) / turn.driven);
  }
  return ratios.size() < kLeastPivots ? 0.0 : median(ratios);
}

/// True if some turns are those that the wheels show, and nearly all the others are those of wheels without signs: to
/// the other side where both run backwards, and a way where they run against each other.
bool have_no_signs(const std::vector<Turn>& turns) {
  const double per_way = turn_per_way_on_the_spot(turns);
  std::size_t as_shown = 0;
  std::size_t without_signs = 0;
  for (const Turn& turn : turns) {
    const auto is_near = [&](double other) {
      return std::abs(turn.turned - other) < kNear * std::abs(turn.turned) + kNoise;
    };
    if (is_near(turn.shown)) {
      ++as_shown;
    } else if (is_near(-turn.shown) || is_near(std::copysign(per_way * turn.driven, turn.turned))) {
      ++without_signs;
    }
  }
  const auto all = static_cast<double>(turns.size());
  return std::min(as_shown, without_signs) >= kLeastSpans && static_cast<double>(without_signs) > kLeastShare * all &&
         static_cast<double>(as_shown + without_signs) > kWhole * all;
}

}  // namespace

void check_unsigned_wheels(Case& c) {
  for (std::size_t i = 0; i < c.watch.sensors().size(); ++i) {
    const WatchedSensor& sensor = c.sensor(i);
    if (!sensor.usual.yaw_scales_with_speed || sensor.yaw.samples() == 0 || c.is_concerned(i)) continue;
    for (std::size_t k = 0; k < c.watch.sensors().size() && !c.is_concerned(i); ++k) {
      const WatchedSensor& other = c.sensor(k);
      // Headings are too noisy over spans so short.
      if (k == i || other.yaw.samples() == 0 || other.has_heading || c.is_concerned(k)) continue;
      if (!have_no_signs(turns_of(sensor, other.yaw, c.watch.newest()))) continue;
      c.add(
          Finding::Certainty::named, "way", {i},
          fmt::format("its wheels never run backwards: some turns are those of {}, and the others fit with signs that "
                      "were lost",
                      other.name),
          fmt::format("source: the signs of the speeds of {}, where the robot reverses or turns on the spot",
                      sensor.name),
          0.0);
    }
  }
}

}  // namespace waymark::host::diagnosis
