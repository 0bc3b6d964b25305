// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "checks.hpp"

namespace waymark::host::diagnosis {

namespace {

using Certainty = Finding::Certainty;

constexpr double kSpan = 0.5;  // [s] of the spans over which lags are sought
constexpr double kSigmas = 4.0;
constexpr double kTolerance = 0.08;    // [s]: half an interval of usual sensors
constexpr double kFixTolerance = 0.3;  // [s]: receivers filter
constexpr double kShareOfInterval = 0.6;
constexpr double kShiftSigma = 0.1;  // [s], of a shift that is known by its step only
constexpr double kPerScale = 8.0;    // [s] of a lag that is no mistake, by the σ of the turns' scale

struct Delay {
  std::size_t sensor;
  Lag lag;
  double tolerance;
};

double interval_of(const WatchedSensor& sensor) { return sensor.intervals.quantile(0.5); }

std::size_t index_of(const Agreement& yaw, const Observer& observer) {
  return static_cast<std::size_t>(&observer - yaw.observers.data());
}

/// Of skid steering and the like, whose turns hardly follow their wheels [s].
double uncertain_turns(const Observer& observer) { return kPerScale * std::max(0.0, observer.usual_sigma - 0.05); }

/// Lag of everything that observes the turns against one of them.
std::vector<Delay> delays_of_turns(Case& c, const MotionAgreement& motion, const Observer& reference) {
  std::vector<Delay> delays;
  const Agreement& yaw = motion.yaw;
  for (std::size_t i = 0; i < yaw.observers.size(); ++i) {
    const Observer& observer = yaw.observers[i];
    const Ratio& direct = yaw.ratios[i][index_of(yaw, reference)];
    const bool is_usable = yaw.is_trusted(i) || direct.verdict == Ratio::Verdict::unknown;
    if (observer.sensor == reference.sensor || !is_usable || c.is_blamed(observer.sensor)) continue;
    const bool is_of_fixes = observer.kind == Observer::Kind::course || observer.kind == Observer::Kind::chord;
    Lag lag;
    if (observer.kind != Observer::Kind::chord) {
      const std::vector<Span> spans =
          observer.track != nullptr ? spans_of(*observer.track, kSpan, c.watch.newest()) : observer.spans;
      lag = find_lag(spans, *reference.track, 1.0);
    }
    // Turns that fit together only if they are shifted.
    if (!lag.is_known && direct.verdict == Ratio::Verdict::agree && direct.shift != 0.0)
      lag = {true, direct.shift, kShiftSigma};
    if (!lag.is_known) continue;
    const double tolerance = is_of_fixes ? kFixTolerance
                                         : kTolerance + uncertain_turns(observer) + uncertain_turns(reference) +
                                               kShareOfInterval * std::max(interval_of(c.sensor(observer.sensor)),
                                                                           interval_of(c.sensor(reference.sensor)));
    delays.push_back({observer.sensor, lag, tolerance});
  }
  return delays;
}

/// The lag that most have, within what is usual; the smallest if several are as good.
double common(const std::vector<double>& lags) {
  double best = 0.0;
  double least = 1e300;
  for (const double lag : lags) {
    double cost = 1e-3 * std::abs(lag);
    for (const double other : lags) cost += std::min(std::abs(other - lag), kFixTolerance);
    if (cost >= least) continue;
    least = cost;
    best = lag;
  }
  return best;
}

void report(Case& c, const Delay& delay, const std::string& against) {
  c.comparisons.push_back(
      {"delay", c.sensor(delay.sensor).name, against, delay.lag.value, delay.lag.sigma, 0, "s behind"});
}

void add_finding(Case& c, const Certainty certainty, const std::vector<std::size_t>& suspects, double late,
                 const Lag& lag, const std::string& against, double sigmas) {
  const WatchedSensor& sensor = c.sensor(suspects.front());
  const double fits = to_seconds(sensor.delay) + late;
  c.add(certainty, "delay", suspects,
        fmt::format("its stamps are {:.2f} ± {:.2f} s behind those of {}", late, lag.sigma, against),
        fmt::format("sensors.{}.delay_s: {:.2f} fits", sensor.name, fits), sigmas);
}

}  // namespace

void check_delays(Case& c, const MotionAgreement& motion) {
  const Observer* reference = motion.yaw.trusted_track();
  if (reference == nullptr) return;
  const std::string& name = c.sensor(reference->sensor).name;
  std::vector<Delay> delays = delays_of_turns(c, motion, *reference);
  const Observer* way = motion.way.trusted_track();
  for (std::size_t i = 0; i < c.watch.sensors().size(); ++i) {
    if (way == nullptr || way->is_unsigned || c.sensor(i).fixes.empty() || c.is_blamed(i) || c.is_blamed(way->sensor))
      continue;
    // What the turns differ in from those of the fixes is taken out.
    double per_way = 0.0;
    for (std::size_t a = 0; a < motion.yaw.observers.size(); ++a) {
      for (std::size_t b = 0; b < motion.yaw.observers.size(); ++b) {
        const Observer& fix = motion.yaw.observers[a];
        if (fix.sensor == i && fix.kind == Observer::Kind::chord && &motion.yaw.observers[b] == reference)
          per_way = -motion.yaw.ratios[a][b].per_way;
      }
    }
    const AntennaFit antenna = fit_antenna(c.sensor(i).fixes, c.sensor(i).usual.p_base_point.head<2>(),
                                           *reference->track, *way->track, per_way, 0.0);
    if (antenna.lag.is_known) delays.push_back({i, antenna.lag, kFixTolerance});
    const bool is_late = antenna.lag.is_known && std::abs(antenna.lag.value) > kFixTolerance;
    if (!is_late) check_antenna(c, i, antenna);
  }
  if (delays.empty()) return;
  for (const Delay& delay : delays) report(c, delay, name);

  // With three or more the one that is not where the others are; of two the later one, since stamps come late.
  std::vector<double> lags{0.0};
  for (const Delay& delay : delays) lags.push_back(delay.lag.value);
  const bool has_majority = lags.size() >= 3;
  const double middle = has_majority ? common(lags) : 0.0;
  for (const Delay& delay : delays) {
    const double late = delay.lag.value - middle;
    const double sigmas = (std::abs(late) - delay.tolerance) / std::max(delay.lag.sigma, 1e-3);
    if (sigmas < kSigmas) continue;
    if (has_majority || late > 0.0) {
      add_finding(c, Certainty::named, {delay.sensor}, late, delay.lag, name, sigmas);
    } else {
      add_finding(c, Certainty::named, {reference->sensor}, -late, delay.lag, c.sensor(delay.sensor).name, sigmas);
    }
  }
  if (has_majority && std::abs(middle) > kTolerance + kShareOfInterval * interval_of(c.sensor(reference->sensor))) {
    const double sigma = delays.front().lag.sigma;
    add_finding(c, Certainty::named, {reference->sensor}, -middle, delays.front().lag, "the others",
                std::abs(middle) / std::max(sigma, 1e-3));
  }
}

}  // namespace waymark::host::diagnosis
