// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <optional>
#include <vector>

#include "checks.hpp"
#include "fit.hpp"

namespace waymark::host::diagnosis {

namespace {

using Certainty = Finding::Certainty;
using Complex = std::complex<double>;

constexpr long kLeastSamples = 20;
constexpr long kLeastSpans = 40;
constexpr double kSpan = 1.0;      // [s]
constexpr double kLeastWay = 0.1;  // [m] in a span, or in a step of a scanner
constexpr double kOneDirection = 0.9;
constexpr double kNoDirection = 0.6;
constexpr double kBeside = 30.0 * kDegree;
constexpr double kStraight = 0.1;      // [rad], a step that turns less is a displacement alone
constexpr double kLengthsAgree = 0.2;  // logarithm

/// The displacement in the axes of the base, as forwards + i left; nothing where none is known.
std::optional<Complex> displacement(const WatchedSensor& sensor, double from, double to) {
  const auto forwards = sensor.way.change(from, to);
  const auto left = sensor.sideways.change(from, to);
  if (!forwards || !left) return std::nullopt;
  const Complex moved(*forwards, *left);
  return std::abs(moved) < kLeastWay ? std::nullopt : std::optional(moved);
}

/// A base that always moves beside its own x axis: its heading counts from another axis. A robot that reverses counts
/// as one that drives on.
void check_own_axis(Case& c, std::size_t i) {
  const WatchedSensor& sensor = c.sensor(i);
  Complex sum;
  long spans = 0;
  for (double t = 0.0; t + kSpan <= c.watch.newest(); t += kSpan) {
    const auto moved = displacement(sensor, t, t + kSpan);
    if (!moved) continue;
    sum += std::polar(1.0, 2.0 * std::arg(*moved));
    ++spans;
  }
  if (spans < kLeastSpans || std::abs(sum) < kOneDirection * static_cast<double>(spans)) return;
  const double beside = 0.5 * std::arg(sum);
  if (std::abs(beside) < kBeside) return;
  c.add(Certainty::named, "direction", {i},
        fmt::format("it moves {:.0f} degrees beside its own x axis ({} spans)", beside / kDegree, spans),
        fmt::format("source: the heading of {} counts from another axis, or its x and y are swapped", sensor.name),
        0.0);
}

/// Displacements of the right length, in directions that have nothing to do with those of a scanner, nor with those of
/// one whose scans are mirrored, which is the scanner's mistake.
void check_against_scans(Case& c, std::size_t i, const WatchedSensor& scanner) {
  const WatchedSensor& sensor = c.sensor(i);
  Complex sum;
  Complex mirrored;
  std::vector<double> lengths;
  for (const ScanStep& step : scanner.steps) {
    if (!step.is_shift_known || std::abs(step.yaw) > kStraight || step.shift.norm() < kLeastWay) continue;
    const auto moved = displacement(sensor, step.from, step.to);
    if (!moved) continue;
    const Complex seen(step.shift.x(), step.shift.y());
    sum += std::polar(1.0, std::arg(seen * std::conj(*moved)));
    mirrored += std::polar(1.0, std::arg(seen * *moved));
    lengths.push_back(std::log(std::abs(*moved) / std::abs(seen)));
  }
  const auto spans = static_cast<long>(lengths.size());
  const double one_direction = std::max(std::abs(sum), std::abs(mirrored));
  if (spans < kLeastSpans || one_direction > kNoDirection * static_cast<double>(spans)) return;
  if (std::abs(median(lengths)) > kLengthsAgree) return;
  c.add(Certainty::named, "direction", {i},
        fmt::format("it moves as far as {} shows, but in other directions ({} spans)", scanner.name, spans),
        fmt::format("source: x and y of {}: swapped, or one of them with the opposite sign", sensor.name), 0.0);
}

}  // namespace

void check_directions(Case& c) {
  for (std::size_t i = 0; i < c.watch.sensors().size(); ++i) {
    if (c.sensor(i).sideways.samples() < kLeastSamples) continue;
    for (const WatchedSensor& scanner : c.watch.sensors()) {
      if (!scanner.steps.empty() && !c.is_blamed(i)) check_against_scans(c, i, scanner);
    }
    if (!c.is_blamed(i)) check_own_axis(c, i);
  }
}

}  // namespace waymark::host::diagnosis
