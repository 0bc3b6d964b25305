// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "checks.hpp"
#include "fit.hpp"

namespace waymark::host::diagnosis {

namespace {

using Certainty = Finding::Certainty;

constexpr double kStep = 2.0;  // [s] between the heights that are compared
constexpr long kLeastSamples = 20;
constexpr double kSigmas = 4.0;
constexpr double kScaleTolerance = 0.15;
constexpr double kLeastCorrelation2 = 0.3;
constexpr double kLevelTolerance = 10.0;  // [m], weather, a geoid that is taken from a coarse table
constexpr double kFoot = 0.3048;

/// One height as a line of another: height = scale · other + level.
struct HeightFit {
  bool is_scale_known = false;
  double scale_low = 0.0;  ///< if all noise is the other one's, or the height's
  double scale_high = 0.0;
  double scale_sigma = 0.0;
  double spread = 0.0;  ///< root mean square of the height about its mean [m]
  double level = 0.0;   ///< median of the difference [m]
  double level_scatter = 0.0;
  long count = 0;
};

std::optional<HeightFit> fit_heights(const Track& height, const Track& other, double newest) {
  Rows rows(static_cast<Eigen::Index>(newest / kStep) + 1, 3);
  std::vector<double> differences;
  for (double t = 0.0; t <= newest && !rows.full(); t += kStep) {
    const auto y = height.at(t);
    const auto x = other.at(t);
    if (!y || !x) continue;
    rows.A.row(rows.count) << *x, 1.0, t;  // a barometer drifts with the weather
    rows.y(rows.count++) = *y;
    differences.push_back(*y - *x);
  }
  if (rows.count < kLeastSamples) return std::nullopt;
  HeightFit result;
  result.count = static_cast<long>(rows.count);
  result.level = median(differences);
  for (double& difference : differences) difference = std::abs(difference - result.level);
  result.level_scatter = kMadToSigma * median(differences);
  // About their means, or scale and level depend on each other.
  for (Eigen::Index column : {0, 2}) {
    auto values = rows.A.col(column).head(rows.count);
    values.array() -= values.mean();
  }
  const Fit fit = fit_rows(rows);
  if (!fit.valid) return result;
  const SlopeBounds bounds = slope_bounds(rows, fit, 0);
  const auto heights = rows.y.head(rows.count).array();
  result.spread = std::sqrt((heights - heights.mean()).square().mean());
  result.is_scale_known = bounds.correlation2 > kLeastCorrelation2;
  result.scale_low = bounds.low;
  result.scale_high = bounds.high;
  result.scale_sigma = fit.sigma(0);
  return result;
}

double scale_of(const HeightFit& fit) {
  return std::copysign(std::sqrt(fit.scale_low * fit.scale_high), fit.scale_low);
}

bool differs_in_scale(const HeightFit& fit) {
  if (!fit.is_scale_known) return false;
  const double margin = kSigmas * fit.scale_sigma;
  return fit.scale_low - margin > 1.0 + kScaleTolerance || fit.scale_high + margin < 1.0 / (1.0 + kScaleTolerance);
}

/// True if the heights wander as far by a receiver's own errors as by another scale.
bool is_by_wander(const HeightFit& fit, const WatchedSensor& other) {
  return !other.is_altimeter() && !exceeds_wander(other, (1.0 - 1.0 / scale_of(fit)) * fit.spread);
}

std::string change_of_scale(const WatchedSensor& altimeter, const std::string& other, double scale) {
  if (std::abs(scale / kFoot - 1.0) < kScaleTolerance)
    return fmt::format("source: height of {} times {:.4g} (feet)", other, kFoot);
  const bool is_feet = std::abs(scale * kFoot - 1.0) < kScaleTolerance;
  return fmt::format("source: height of {} times {:.4g}{}", altimeter.name, is_feet ? kFoot : 1.0 / scale,
                     is_feet ? " (feet)" : "");
}

void compare_heights(Case& c, std::size_t altimeter, std::size_t other) {
  const WatchedSensor& sensor = c.sensor(altimeter);
  const auto fit = fit_heights(sensor.height, c.sensor(other).height, c.watch.newest());
  if (!fit) return;
  const bool is_other_fix = !c.sensor(other).is_altimeter();
  const std::string& name = c.sensor(other).name;
  if (fit->is_scale_known)
    c.comparisons.push_back({"height", sensor.name, name, scale_of(*fit), fit->scale_sigma, fit->count,
                             differs_in_scale(*fit) ? "differ" : "agree"});
  if (differs_in_scale(*fit) && is_by_wander(*fit, c.sensor(other))) return;
  if (differs_in_scale(*fit)) {
    const double scale = scale_of(*fit);
    // Receivers do not turn heights over.
    const bool is_named = is_other_fix && scale < 0.0;
    c.add(is_named ? Certainty::named : Certainty::one_of, "height",
          is_named ? std::vector{altimeter} : std::vector{altimeter, other},
          fmt::format("{}its height changes {:.3g} ± {:.2g} times as much as that of {}",
                      is_named ? "" : sensor.name + ": ", scale, fit->scale_sigma, name),
          change_of_scale(sensor, name, scale), std::abs(scale - 1.0) / std::max(fit->scale_sigma, 1e-6));
    return;
  }
  const double offset_sigma =
      std::hypot(sensor.usual.height_offset_sigma_m, c.sensor(other).usual.height_offset_sigma_m);
  c.comparisons.push_back({"height", sensor.name, name, fit->level, fit->level_scatter, fit->count, "m between them"});
  const double tolerance = std::max(kLevelTolerance, kSigmas * offset_sigma);
  const double sigmas = (std::abs(fit->level) - tolerance) / std::max(fit->level_scatter, 0.1);
  if (sigmas < kSigmas) return;
  const double level = c.setting(altimeter, "level_m");
  c.add(Certainty::one_of, "height", {altimeter, other},
        fmt::format("{}: its height is {:.1f} ± {:.1f} m {} that of {}", sensor.name, std::abs(fit->level),
                    fit->level_scatter, fit->level > 0.0 ? "above" : "below", name),
        fmt::format("sensors.{}.level_m: {:.1f} fits{}", sensor.name, (std::isfinite(level) ? level : 0.0) - fit->level,
                    is_other_fix ? ", or another altitude of the datum" : ""),
        sigmas);
}

/// An altimeter in another unit, which climbs farther than the robot drives.
void check_unit(Case& c, std::size_t i, const MotionAgreement& motion) {
  constexpr double kSpan = 5.0;         // [s]
  constexpr double kLeastWay = 1.0;     // [m] of a span
  constexpr double kLeastWhole = 20.0;  // [m]
  constexpr double kSteepest = 2.0;     // no vehicle climbs so far by the way that it drives
  constexpr double kOrdinary = 0.2;
  const Observer* way = motion.way.trusted_track();
  if (way == nullptr || c.is_concerned(way->sensor)) return;
  double climbed = 0.0;
  double driven = 0.0;
  for (double t = 0.0; t + kSpan <= c.watch.newest(); t += kSpan) {
    const auto up = c.sensor(i).height.change(t, t + kSpan);
    const auto along = way->track->change(t, t + kSpan);
    if (!up || !along || std::abs(*along) < kLeastWay) continue;
    climbed += std::abs(*up);
    driven += std::abs(*along);
  }
  if (driven < kLeastWhole || climbed < kSteepest * driven) return;
  const bool is_cm = 0.01 * climbed < kOrdinary * driven;
  c.add(Certainty::named, "height", {i},
        fmt::format("its height climbs and falls by {:.0f} m on {:.0f} m of way of {}", climbed, driven,
                    c.sensor(way->sensor).name),
        is_cm ? fmt::format("source: height of {} times 0.01 (cm) or 0.001 (mm)", c.sensor(i).name)
              : fmt::format("source: the unit of the height of {}, mm: times 0.001", c.sensor(i).name),
        0.0);
}

}  // namespace

bool exceeds_wander(const WatchedSensor& receiver, double difference) {
  constexpr double kSigmasOfWander = 3.0;
  return std::abs(difference) > kSigmasOfWander * receiver.usual.height_offset_sigma_m;
}

void check_heights(Case& c, const MotionAgreement& motion) {
  if (c.robot.settings.motion != StateLayout::Motion::spatial) return;  // heights are ignored
  for (std::size_t i = 0; i < c.watch.sensors().size(); ++i) {
    if (!c.sensor(i).is_altimeter() || c.sensor(i).height.samples() < kLeastSamples || c.is_blamed(i)) continue;
    check_unit(c, i, motion);
    if (c.is_blamed(i)) continue;
    for (std::size_t k = 0; k < c.watch.sensors().size(); ++k) {
      const bool is_pair = k != i && !(c.sensor(k).is_altimeter() && k < i);  // of two altimeters once
      if (is_pair && c.sensor(k).height.samples() >= kLeastSamples && !c.is_blamed(k)) compare_heights(c, i, k);
    }
  }
}

}  // namespace waymark::host::diagnosis
