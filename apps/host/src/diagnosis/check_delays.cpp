// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "checks.hpp"

namespace waymark::host::diagnosis {

namespace {

using Certainty = Finding::Certainty;

constexpr double kSpan = 0.5;  // [s] of the spans over which lags are sought
constexpr double kSigmas = 4.0;
constexpr double kTolerance = 0.08;    // [s]: half an interval of usual sensors
constexpr double kFixTolerance = 0.3;  // [s], of positions: receivers filter; less where the delay is well known:
constexpr double kLeastFixTolerance = 0.15;
constexpr double kFixSigmas = 10.0;
constexpr double kFreeTolerance = 0.2;   // [s] more
constexpr double kTiltTolerance = 0.35;  // [s]
constexpr double kUsualDelay = 0.1;      // [s], of a receiver whose positions are exact
constexpr double kPositionSigmas = 2.0;  // as far as a robot drives in a delay that does not matter
constexpr double kShareOfInterval = 0.6;
constexpr double kEarly = 2.0;          // by so much an early stamp is less likely than a late one
constexpr double kDecides = 1.5;        // by so much one delay must be likelier than another to be named
constexpr double kSpeaksAgainst = 4.0;  // squares of σ by which another explanation must fit worse: 2 σ
constexpr double kLeastSigma = 1e-3;    // [s]
constexpr double kShiftSigma = 0.1;     // [s], of a shift that is known by its step only
constexpr double kLeastSpeed = 0.05;    // [m/s]
constexpr double kSpeedSpread = 0.3;    // of the speed in turns, as a share
constexpr double kPerScale = 8.0;       // [s] of a lag that is no mistake, by the σ of the turns' scale

/// How far the stamps of one sensor are behind those of another.
struct Delay {
  std::size_t sensor;
  std::size_t against;
  Lag lag;
  double tolerance;
  bool is_of_velocity = false;       ///< of `sensor`: its course over ground, not its positions
  bool is_against_velocity = false;  ///< of `against`

  /// How far it is from what a sensor's own delays leave of it, beyond what is usual, in σ.
  double sigmas(const std::vector<double>& own) const {
    const double rest = lag.value - own[sensor] + own[against];
    return beyond(rest, tolerance, std::max(lag.sigma, kLeastSigma));
  }
};

double interval_of(const WatchedSensor& sensor) { return sensor.intervals.quantile(0.5); }

/// Of skid steering and the like, whose turns hardly follow their wheels [s].
double uncertain_turns(const Observer& observer) { return kPerScale * std::max(0.0, observer.usual_sigma - 0.05); }

/// A heading that turns as the robot tilts, early or late.
bool is_tilting_field(const Case& c, const Observer& observer) {
  return is_field(c, observer) && turns_by_tilt(c, c.sensor(observer.sensor)) > kTilts;
}

double tolerance_of(const Case& c, const Observer& a, const Observer& b) {
  const auto is_any = [&](Observer::Kind kind) { return a.kind == kind || b.kind == kind; };
  // What has no wheels follows its bow, and what flies may turn it into the path afterwards.
  if (is_any(Observer::Kind::course) && measured_way(c.watch) == nullptr) return kFixTolerance + kFreeTolerance;
  if (is_tilting_field(c, a) || is_tilting_field(c, b)) return kTiltTolerance;
  if (is_any(Observer::Kind::chord)) return kFixTolerance;
  return kTolerance + uncertain_turns(a) + uncertain_turns(b) +
         kShareOfInterval * std::max(interval_of(c.sensor(a.sensor)), interval_of(c.sensor(b.sensor)));
}

/// How much earlier than the base an antenna ahead of it shows a turn [s]: by a way, so by less at a higher speed.
double lead_of(const Case& c, const Observer& observer) {
  if (observer.kind != Observer::Kind::course && observer.kind != Observer::Kind::chord) return 0.0;
  const WatchedSensor& sensor = c.sensor(observer.sensor);
  double speed = sensor.speeds.quantile(0.5);
  for (const WatchedSensor& other : c.watch.sensors()) {
    if (speed == 0.0 && other.way.samples() > 0) speed = other.speeds.quantile(0.5);
  }
  const double ahead = sensor.usual.p_base_point.x();
  return speed > kLeastSpeed && std::isfinite(ahead) ? ahead / speed : 0.0;
}

/// True if a receiver's positions follow dead reckoning at another time than their directions turn: on circles these
/// fit at many times.
bool contradicts_reckoning(const std::vector<Delay>& delays, std::size_t receiver, const Lag& turned) {
  constexpr double kContradicts = 3.0;  // σ
  return std::ranges::any_of(delays, [&](const Delay& delay) {
    return delay.sensor == receiver && !delay.is_of_velocity &&
           std::abs(delay.lag.value - turned.value) > kContradicts * std::hypot(delay.lag.sigma, turned.sigma);
  });
}

/// Lags of the turns of each against those of each other one.
void add_delays_of_turns(const Case& c, const MotionAgreement& motion, std::vector<Delay>& delays) {
  const Agreement& yaw = motion.yaw;
  const std::vector<Observer>& observers = yaw.observers;
  std::vector<double> leads;
  leads.reserve(observers.size());
  for (const Observer& observer : observers) leads.push_back(lead_of(c, observer));
  for (std::size_t j = 0; j < observers.size(); ++j) {
    const Observer& reference = observers[j];
    if (reference.track == nullptr || !yaw.is_trusted(j) || c.is_blamed(reference.sensor)) continue;
    for (std::size_t i = 0; i < observers.size(); ++i) {
      const Observer& observer = observers[i];
      const Ratio& direct = yaw.ratios[i][j];
      const bool is_usable = yaw.is_trusted(i) || direct.verdict == Ratio::Verdict::unknown;
      const bool is_done = observer.track != nullptr && yaw.is_trusted(i) && i < j;
      if (observer.sensor == reference.sensor || !is_usable || is_done || c.is_blamed(observer.sensor)) continue;
      if (direct.is_forgiven && (is_of_path(observer) || is_of_path(reference))) continue;
      Lag lag;
      if (observer.kind != Observer::Kind::chord) {
        const std::vector<Span> spans =
            observer.track != nullptr ? spans_of(*observer.track, kSpan, c.watch.newest()) : observer.spans;
        lag = find_lag(spans, *reference.track, 1.0);
      }
      // Turns that fit together only if they are shifted.
      if (!lag.is_known && direct.verdict == Ratio::Verdict::agree && direct.shift != 0.0) {
        lag = {true, direct.shift, kShiftSigma};
        if (observer.kind == Observer::Kind::chord && contradicts_reckoning(delays, observer.sensor, lag)) continue;
      }
      if (!lag.is_known) continue;
      const double lead = leads[i] - leads[j];
      lag.value += lead;
      lag.sigma = std::hypot(lag.sigma, kSpeedSpread * lead);
      delays.push_back({observer.sensor, reference.sensor, lag, tolerance_of(c, observer, reference),
                        observer.kind == Observer::Kind::course, reference.kind == Observer::Kind::course});
    }
  }
}

/// What of a receiver's delay is usual.
double tolerance_of_fixes(const Lag& lag) {
  return std::clamp(kFixSigmas * lag.sigma, kLeastFixTolerance, kFixTolerance);
}

/// The longest delay of a receiver that does not matter beside the noise of its positions [s].
double least_delay_that_matters(const WatchedSensor& receiver, double speed) {
  const double noise = kPositionSigmas * receiver.usual.position_sigma_m / std::max(speed, kLeastSpeed);
  return std::isfinite(noise) ? std::clamp(kUsualDelay + noise, kLeastFixTolerance, kFixTolerance) : kFixTolerance;
}

/// How far the turns of the sensor that measures the way are behind those of the reference [s].
double lag_of_way(const Case& c, const Observer& way, const Observer& reference) {
  const WatchedSensor& sensor = c.sensor(way.sensor);
  if (way.sensor == reference.sensor || sensor.yaw.samples() == 0) return 0.0;
  const Lag lag = find_lag(spans_of(sensor.yaw, kSpan, c.watch.newest()), *reference.track, 1.0);
  return lag.is_known ? lag.value : 0.0;
}

/// The bias of an observer's rate [rad/s]: what it turns more than the sensor whose turns agree with its own best.
double bias_of(const Agreement& yaw, const Observer& observer) {
  const auto index = static_cast<std::size_t>(&observer - yaw.observers.data());
  const Partner best = best_known(yaw, index, &Ratio::offset_sigma, [&](const Ratio& ratio, std::size_t sensor) {
    return sensor != observer.sensor && ratio.verdict == Ratio::Verdict::agree;
  });
  return best.ratio != nullptr ? best.ratio->offset : 0.0;
}

/// Lags of positions against dead reckoning; judges the lever arms of those that are not late.
void add_delays_of_positions(Case& c, const MotionAgreement& motion, std::vector<Delay>& delays) {
  const Observer* reference = motion.yaw.trusted_track();
  const Observer* way = motion.way.trusted_track();
  if (reference == nullptr || way == nullptr || way->is_unsigned || c.is_blamed(way->sensor)) return;
  if (c.is_blamed(reference->sensor, "clock")) return;  // it is late by another time at every fix
  // A heading has no bias, and only what comes from wheels has a turn per way.
  const Role role = c.sensor(reference->sensor).role();
  const double bias = role == Role::heading ? 0.0 : bias_of(motion.yaw, *reference);
  const double speed = c.sensor(way->sensor).speeds.quantile(0.5);
  for (std::size_t i = 0; i < c.watch.sensors().size(); ++i) {
    if (c.sensor(i).fixes.empty() || c.is_blamed(i) || i == reference->sensor) continue;
    // What the turns differ in from those of the fixes is taken out.
    double per_way = 0.0;
    for (std::size_t a = 0; a < motion.yaw.observers.size(); ++a) {
      for (std::size_t b = 0; b < motion.yaw.observers.size(); ++b) {
        const Observer& fix = motion.yaw.observers[a];
        if (role == Role::wheels && fix.sensor == i && fix.kind == Observer::Kind::chord &&
            &motion.yaw.observers[b] == reference)
          per_way = -motion.yaw.ratios[a][b].per_way;
      }
    }
    const double late = lag_of_way(c, *way, *reference);
    const AntennaFit antenna = fit_antenna(c.sensor(i).fixes, c.sensor(i).usual.p_base_point.head<2>(),
                                           *reference->track, way_of(c, *way), per_way, bias, late);
    // Late or off the axle, fixes follow each other as smoothly as others.
    if (antenna.is_known) {
      const double scatter = std::min(antenna.residual / std::numbers::sqrt2, noise_of(c.sensor(i).fixes));
      check_scatter(c, i, scatter, kSlipScatter);
      if (c.is_blamed(i)) continue;
    }
    const double tolerance = least_delay_that_matters(c.sensor(i), speed);
    // A long one that explains nothing is noise, which has its least somewhere.
    const bool is_noise = !antenna.is_lag_likelier && std::abs(antenna.lag.value) > kFixTolerance;
    const bool may_be_late = antenna.lag.is_known && !antenna.is_lever_likelier && !is_noise;
    if (may_be_late) delays.push_back({i, reference->sensor, antenna.lag, tolerance});
    // At one speed a delay looks like an antenna further back.
    const bool is_late = may_be_late && beyond(antenna.lag.value, tolerance, antenna.lag.sigma) >= kSigmas;
    const bool is_in_time = std::abs(antenna.lag.value) <= tolerance_of_fixes(antenna.lag);
    if (!may_be_late || (is_in_time && !is_late)) check_antenna(c, i, antenna);
  }
}

/// How far a receiver's positions, or its velocity, are behind another sensor; not known if nothing compared them.
Lag behind(const std::vector<Delay>& delays, std::size_t receiver, std::size_t other, bool is_of_velocity) {
  for (const Delay& delay : delays) {
    if (delay.sensor == receiver && delay.against == other && delay.is_of_velocity == is_of_velocity) return delay.lag;
    if (delay.against == receiver && delay.sensor == other && delay.is_against_velocity == is_of_velocity)
      return {delay.lag.is_known, -delay.lag.value, delay.lag.sigma};
  }
  return {};
}

/// A receiver whose course and speed are of another time than its positions: no delay of the sensor mends both.
void check_own_velocity(Case& c, std::vector<Delay>& delays) {
  for (std::size_t i = 0; i < c.watch.sensors().size(); ++i) {
    const WatchedSensor& sensor = c.sensor(i);
    if (sensor.fixes.empty() || c.is_concerned(i)) continue;
    // By the same sensor, whose own delay is in both.
    Lag positions;
    Lag velocity;
    for (std::size_t k = 0; k < c.watch.sensors().size(); ++k) {
      const Lag p = behind(delays, i, k, false);
      const Lag v = behind(delays, i, k, true);
      if (!p.is_known || !v.is_known) continue;
      const bool is_better =
          !positions.is_known || std::hypot(p.sigma, v.sigma) < std::hypot(positions.sigma, velocity.sigma);
      if (is_better) std::tie(positions, velocity) = std::pair(p, v);
    }
    if (!positions.is_known) continue;
    const double older = velocity.value - positions.value;
    const double sigma = std::hypot(velocity.sigma, positions.sigma);
    const double sigmas = beyond(older, kFixTolerance, sigma);
    if (sigmas < kSigmas) continue;
    c.add(
        Certainty::named, "delay", {i},
        fmt::format("its course and speed are {:.2f} ± {:.2f} s {} its positions", std::abs(older), sigma,
                    older > 0.0 ? "behind" : "ahead of"),
        fmt::format("source: course and speed of {}: another message of the receiver, or leave them out", sensor.name),
        sigmas);
    const bool drops_velocity = std::abs(velocity.value) >= std::abs(positions.value);
    std::erase_if(delays, [&](const Delay& delay) {
      return (delay.sensor == i && delay.is_of_velocity == drops_velocity) ||
             (delay.against == i && delay.is_against_velocity == drops_velocity);
    });
  }
}

/// What of a sensor a delay is of.
std::string label(const Case& c, std::size_t index, bool is_velocity) {
  const WatchedSensor& sensor = c.sensor(index);
  if (sensor.fixes.empty()) return sensor.name;
  return sensor.name + (is_velocity ? " velocity" : " positions");
}

/// A sensor that is late by itself, and what that leaves.
struct Culprit {
  std::size_t sensor = 0;
  double late = 0.0;
  std::size_t contradictions = 0;  ///< that remain
  double misfit = 0.0;             ///< sum of the squares of all delays that remain, in σ
  double unlikely = 0.0;           ///< of the delay that the YAML would then give it [s]

  bool is_simpler_than(const Culprit& other) const {
    if (contradictions != other.contradictions) return contradictions < other.contradictions;
    return unlikely < other.unlikely;
  }
  /// `other` is the simplest one; the delays that are no contradictions may speak against it.
  bool is_as_simple_as(const Culprit& other) const {
    return contradictions == other.contradictions &&
           (unlikely < kDecides * other.unlikely || misfit + kSpeaksAgainst < other.misfit);
  }
};

/// Most delays are none; stamps that are early are rarer than late ones.
double unlikeliness(double delay_s) { return delay_s >= 0.0 ? delay_s : -kEarly * delay_s; }

std::size_t contradictions(const std::vector<Delay>& delays, const std::vector<double>& own) {
  return static_cast<std::size_t>(
      std::ranges::count_if(delays, [&](const Delay& delay) { return delay.sigmas(own) >= kSigmas; }));
}

double misfit(const std::vector<Delay>& delays, const std::vector<double>& own) {
  double sum = 0.0;
  for (const Delay& delay : delays) {
    const double rest = delay.lag.value - own[delay.sensor] + own[delay.against];
    // The tolerance is that of 3 σ of what is usual.
    sum += std::pow(rest / std::hypot(delay.lag.sigma, delay.tolerance / 3.0), 2);
  }
  return sum;
}

/// Sensors whose delay alone explains some contradictions, the simplest explanation first; those that explain less are
/// left out.
std::vector<Culprit> simplest(const Case& c, const std::vector<Delay>& delays, const std::vector<double>& own) {
  std::vector<Culprit> culprits;
  const std::size_t before = contradictions(delays, own);
  for (const Delay& contradiction : delays) {
    if (contradiction.sigmas(own) < kSigmas) continue;
    const double rest = contradiction.lag.value - own[contradiction.sensor] + own[contradiction.against];
    for (const bool is_first : {true, false}) {
      Culprit tried{is_first ? contradiction.sensor : contradiction.against, is_first ? rest : -rest};
      if (own[tried.sensor] != 0.0) continue;
      std::vector<double> moved = own;
      moved[tried.sensor] = tried.late;
      tried.contradictions = contradictions(delays, moved);
      tried.misfit = misfit(delays, moved);
      tried.unlikely = unlikeliness(to_seconds(c.sensor(tried.sensor).delay) + tried.late);
      if (tried.contradictions < before) culprits.push_back(tried);
    }
  }
  std::ranges::stable_sort(culprits, [](const Culprit& a, const Culprit& b) { return a.is_simpler_than(b); });
  std::erase_if(culprits, [first = culprits.empty() ? Culprit{} : culprits.front()](const Culprit& one) {
    return !one.is_as_simple_as(first);
  });
  return culprits;
}

/// Names a sensor with the clearest of its delays; `suspects` has it first, and those that explain as much.
void add_finding(Case& c, const std::vector<Delay>& delays, const std::vector<double>& own, const Culprit& culprit,
                 const std::vector<std::size_t>& suspects) {
  const Delay* clearest = nullptr;
  std::vector<std::string> others;
  for (const Delay& delay : delays) {
    if ((delay.sensor != culprit.sensor && delay.against != culprit.sensor) || delay.sigmas(own) < kSigmas) continue;
    const std::string& other = c.sensor(delay.sensor == culprit.sensor ? delay.against : delay.sensor).name;
    if (std::ranges::find(others, other) == others.end()) others.push_back(other);
    if (clearest == nullptr || delay.lag.sigma < clearest->lag.sigma) clearest = &delay;
  }
  if (clearest == nullptr) return;
  const double rest = clearest->lag.value - own[clearest->sensor] + own[clearest->against];
  const double late = clearest->sensor == culprit.sensor ? rest : -rest;
  const WatchedSensor& sensor = c.sensor(culprit.sensor);
  const bool is_open = suspects.size() > 1;
  c.add(is_open ? Certainty::one_of : Certainty::named, "delay", suspects,
        fmt::format("{}its stamps are {:.2f} ± {:.2f} s {} those of {}", is_open ? sensor.name + ": " : "",
                    std::abs(late), clearest->lag.sigma, late > 0.0 ? "behind" : "ahead of", fmt::join(others, ", ")),
        fmt::format("sensors.{}.delay_s: {:.2f} fits", sensor.name, to_seconds(sensor.delay) + late),
        clearest->sigmas(own));
}

}  // namespace

void check_delays(Case& c, const MotionAgreement& motion) {
  std::vector<Delay> delays;
  // Positions first: an antenna that is found to stand elsewhere leads or lags in turns.
  add_delays_of_positions(c, motion, delays);
  add_delays_of_turns(c, motion, delays);
  for (const Delay& delay : delays) {
    c.comparisons.push_back({"delay", label(c, delay.sensor, delay.is_of_velocity),
                             label(c, delay.against, delay.is_against_velocity), delay.lag.value, delay.lag.sigma, 0,
                             "s behind"});
  }
  check_own_velocity(c, delays);
  std::vector<double> own(c.watch.sensors().size(), 0.0);
  while (true) {
    const std::vector<Culprit> culprits = simplest(c, delays, own);
    if (culprits.empty()) return;
    std::vector<std::size_t> suspects;
    for (const Culprit& culprit : culprits) {
      if (std::ranges::find(suspects, culprit.sensor) == suspects.end()) suspects.push_back(culprit.sensor);
    }
    add_finding(c, delays, own, culprits.front(), suspects);
    own[culprits.front().sensor] = culprits.front().late;
  }
}

}  // namespace waymark::host::diagnosis
