// SPDX-License-Identifier: Apache-2.0
#include "observers.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "fit.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::host::diagnosis {

namespace {

constexpr double kTurnSpan = 2.0;  // [s] of the spans over which turns are compared
constexpr double kWaySpan = 2.0;
constexpr double kLeastChord = 1.0;     // [m]
constexpr double kChordSigmas = 10.0;   // of the fixes' noise
constexpr double kShortestChord = 1.0;  // [s], or a lag of the fixes spoils every comparison
constexpr double kLongestChord = 12.0;  // [s]
constexpr double kSharp = 2.2;          // [rad], chords that turn more are reversals
constexpr double kBent = 1.5;           // [rad], in a chord
constexpr double kAbsurd = 12.0;        // [rad], in more than a few of the chords: no turns but another unit
constexpr double kFew = 0.95;
constexpr long kLeastSamples = 20;

/// How far the robot turns within a chord: by the sensor that turns least, so that one which is wrong does not decide;
/// nothing if none measures it.
std::optional<double> turn_within(const Watch& watch, const Chord& chord) {
  constexpr double kStep = 0.25;  // [s]
  std::optional<double> least;
  for (const WatchedSensor& sensor : watch.sensors()) {
    if (sensor.yaw.samples() < kLeastSamples) continue;
    double most = 0.0;
    bool is_known = true;
    for (double t = chord.from + kStep; is_known && t < chord.to + kStep; t += kStep) {
      const auto turned = sensor.yaw.change(chord.from, std::min(t, chord.to));
      is_known = turned.has_value();
      if (is_known) most = std::max(most, std::abs(*turned));
    }
    if (is_known) least = std::min(least.value_or(most), most);
  }
  return least;
}

/// Chords that turn so little that their direction is a heading and their length a way: where fixes are noisy, chords
/// are longer than tight curves. All of them where the turns cannot be right.
std::vector<Chord> straight_chords_of(const Watch& watch, const std::vector<Fix>& fixes) {
  std::vector<Chord> all = chords_of(fixes);
  std::vector<Chord> straight;
  std::vector<double> turns;
  turns.reserve(all.size());
  for (const Chord& chord : all) {
    const double turned = turn_within(watch, chord).value_or(0.0);
    turns.push_back(turned);
    if (turned < kBent) straight.push_back(chord);
  }
  if (turns.empty()) return all;
  const auto high = turns.begin() + static_cast<std::ptrdiff_t>(kFew * static_cast<double>(turns.size() - 1));
  std::ranges::nth_element(turns, high);
  return *high > kAbsurd ? all : straight;
}

}  // namespace

double noise_of(const std::vector<Fix>& fixes) {
  std::vector<double> differences;
  for (std::size_t k = 2; k < fixes.size(); ++k) {
    const double before = fixes[k - 1].t - fixes[k - 2].t;
    const double after = fixes[k].t - fixes[k - 1].t;
    if (before > 1.5 || std::abs(before - after) > 0.2 * before) continue;
    const Eigen::Vector2d d = fixes[k].p - 2.0 * fixes[k - 1].p + fixes[k - 2].p;
    differences.push_back(std::abs(d.x()));
    differences.push_back(std::abs(d.y()));
  }
  return kMadToSigma * median(differences) / std::sqrt(6.0);
}

std::vector<Chord> chords_of(const std::vector<Fix>& fixes) {
  std::vector<Chord> chords;
  if (fixes.size() < 3) return chords;
  const double least = std::max(kLeastChord, kChordSigmas * noise_of(fixes));
  std::size_t from = 0;
  for (std::size_t k = 1; k < fixes.size(); ++k) {
    while (fixes[k].t - fixes[from].t > kLongestChord) ++from;
    const Eigen::Vector2d d = fixes[k].p - fixes[from].p;
    if (d.norm() < least || fixes[k].t - fixes[from].t < kShortestChord) continue;
    chords.push_back({fixes[from].t, fixes[k].t, d.norm(), std::atan2(d.y(), d.x())});
    from = k;
  }
  return chords;
}

const Track* measured_way(const Watch& watch) {
  for (const WatchedSensor& sensor : watch.sensors()) {
    if (sensor.way.samples() >= kLeastSamples) return &sensor.way;
  }
  return nullptr;
}

std::vector<Observer> yaw_observers(const Watch& watch) {
  std::vector<Observer> observers;
  for (std::size_t i = 0; i < watch.sensors().size(); ++i) {
    const WatchedSensor& sensor = watch.sensors()[i];
    const bool is_wheels = sensor.role() == Role::wheels;
    if (sensor.yaw.samples() >= kLeastSamples) {
      observers.push_back({i, Observer::Kind::measured, &sensor.yaw, spans_of(sensor.yaw, kTurnSpan, watch.newest()),
                           is_wheels ? sensor.usual.yaw_scale_sigma : 0.01, sensor.usual.curvature_sigma_per_m, false});
    }
    if (sensor.course.samples() >= kLeastSamples) {
      observers.push_back({i, Observer::Kind::course, &sensor.course,
                           spans_of(sensor.course, kTurnSpan, watch.newest()), 0.02, 0.0, false});
    }
    if (const std::vector<Chord> chords = straight_chords_of(watch, sensor.fixes); chords.size() >= kLeastSamples) {
      Observer turns{i, Observer::Kind::chord, nullptr, {}, 0.04, 0.0, false};
      for (std::size_t k = 1; k < chords.size(); ++k) {
        const Chord& a = chords[k - 1];
        const Chord& b = chords[k];
        const double turn = so3::wrap(b.direction - a.direction);
        if (b.from - a.to > 1.0 || std::abs(turn) > kSharp) continue;
        turns.spans.push_back({0.5 * (a.from + a.to), 0.5 * (b.from + b.to), turn});
      }
      observers.push_back(std::move(turns));
    }
    if (sensor.steps.size() >= kLeastSamples) {
      Observer turns{i, Observer::Kind::matched, nullptr, {}, 0.02, 0.0, false};
      for (const ScanStep& step : sensor.steps) turns.spans.push_back({step.from, step.to, step.yaw});
      observers.push_back(std::move(turns));
    }
  }
  return observers;
}

std::vector<Observer> way_observers(const Watch& watch) {
  std::vector<Observer> observers;
  for (std::size_t i = 0; i < watch.sensors().size(); ++i) {
    const WatchedSensor& sensor = watch.sensors()[i];
    if (sensor.way.samples() >= kLeastSamples) {
      observers.push_back({i, Observer::Kind::measured, &sensor.way, spans_of(sensor.way, kWaySpan, watch.newest()),
                           sensor.usual.speed_scale_sigma, 0.0, false});
    }
    if (sensor.ground_way.samples() >= kLeastSamples) {
      observers.push_back({i, Observer::Kind::course, &sensor.ground_way,
                           spans_of(sensor.ground_way, kWaySpan, watch.newest()), 0.02, 0.0, true});
    }
    if (const std::vector<Chord> chords = straight_chords_of(watch, sensor.fixes); chords.size() >= kLeastSamples) {
      Observer lengths{i, Observer::Kind::chord, nullptr, {}, 0.02, 0.0, true};
      for (const Chord& chord : chords) lengths.spans.push_back({chord.from, chord.to, chord.length});
      observers.push_back(std::move(lengths));
    }
  }
  return observers;
}

}  // namespace waymark::host::diagnosis
