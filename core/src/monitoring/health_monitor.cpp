// SPDX-License-Identifier: Apache-2.0
#include "monitoring/health_monitor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "waymark/base/error.hpp"

namespace waymark::monitoring {

namespace {

/// Shares and means run over about this many measurements of a sensor: few enough to see a fault within seconds, many
/// enough that one outlier is none.
constexpr double kWindow = 20.0;
constexpr double kKnown = 5.0;  // measurements from which a share says something
constexpr double kDegradedShare = 0.15;
constexpr double kFaultyShare = 0.5;
/// Mean NIS over its degrees of freedom from which a sensor's noise, or the belief, is called wrong: for one degree of
/// freedom and the window, χ² exceeds it once in 10⁴.
constexpr double kDegradedNis = 2.5;
constexpr Duration kSilence = std::chrono::seconds(1);  // at least; for slow sensors several of their intervals
constexpr double kSilentIntervals = 5.0;
constexpr Duration kNeverDelivered = std::chrono::seconds(10);
constexpr Duration kAfterReacquisition = std::chrono::seconds(5);
constexpr Duration kDoubtLasts = std::chrono::seconds(2);
/// P(χ² with two degrees of freedom > 9) = exp(−9 / 2): outside the 3σ ellipse of an honest covariance.
constexpr double kThreeSigmaSquared = 9.0;

/// Assigns only what differs: a host asks thousands of times a second, and strings live on the heap.
template <class State>
void settle(State& state, State to, std::string& reason, std::string_view why) {
  state = to;
  if (reason != why) reason = why;
}

bool usable(Fate fate) { return fate != Fate::unusable && fate != Fate::mistimed; }

}  // namespace

HealthMonitor::HealthMonitor(const HealthSettings& settings, const std::vector<Role>& roles, bool motion_from_maps)
    : settings_(settings), motion_from_maps_(motion_from_maps) {
  for (const Role& role : roles) {
    sensors_.emplace_back();
    sensors_.back().role = role;
  }
  health_.sensors.resize(roles.size());
  health_.probability_off_3_sigma = std::exp(-0.5 * kThreeSigmaSquared);
}

void HealthMonitor::record(std::size_t index, Time stamp, const UpdateResult& what) {
  Track& track = sensors_[index];
  if (track.last && stamp > *track.last) {
    const double dt = to_seconds(stamp - *track.last);
    track.interval += (track.interval == 0.0 ? 1.0 : 1.0 / kWindow) * (dt - track.interval);
  }
  track.last = std::max(track.last.value_or(stamp), stamp);
  if (what.fate == Fate::held_out || what.fate == Fate::ignored || what.fate == Fate::before_start) return;
  track.count = std::min(track.count + 1.0, kWindow);
  const double share = 1.0 / track.count;
  track.gated += share * ((what.fate == Fate::gated ? 1.0 : 0.0) - track.gated);
  track.unusable += share * ((usable(what.fate) ? 0.0 : 1.0) - track.unusable);
  if (what.dof > 0) {
    // What the gate rejects counts, but a fix 800 m off must not be remembered for minutes.
    constexpr double kClamp = 12.0;
    track.nis_ratio += share * (std::min(what.nis / what.dof, kClamp) - track.nis_ratio);
  }
  if (what.located) {
    track.was_located = track.was_located || *what.located;
    track.located = *what.located || !(track.was_located || track.role.has_prior_map);
    track.steps = std::min(track.steps + 1.0, kWindow);
    track.not_localized += (1.0 / track.steps) * ((*what.located ? 0.0 : 1.0) - track.not_localized);
  }
  // A scan that the maps passed over ties the robot no better and no worse than the last one that they took.
  if (usable(what.fate) && what.fate != Fate::gated && track.located) track.last_good = track.last;
  if (!what.doubt.empty()) {
    if (track.doubt != what.doubt) track.doubt = what.doubt;
    track.doubted = stamp;
  }
}

void HealthMonitor::mistimed(std::size_t index, Time stamp) {
  record(index, sensors_[index].last.value_or(stamp), {.fate = Fate::mistimed, .doubt = "its stamps cannot be right"});
}

bool HealthMonitor::is_not_localized(const Track& track) {
  return track.role.has_prior_map && track.steps >= kKnown && track.not_localized > kFaultyShare;
}

void HealthMonitor::judge_sensor(const Track& track, Time now, SensorHealth& health) const {
  using enum SensorHealth::State;
  const auto say = [&](SensorHealth::State state, std::string_view why) {
    settle(health.state, state, health.reason, why);
  };
  if (track.broken) return say(faulty, "out of service");
  if (!track.role.fused) return say(ok, "");
  if (!track.last) {
    if (started_ && now - *started_ > kNeverDelivered) return say(silent, "has never delivered");
    return say(ok, "");
  }
  const Duration patience = std::max(kSilence, from_seconds(kSilentIntervals * track.interval));
  if (now - *track.last > patience) return say(silent, "has stopped");
  const bool doubted = track.doubted && now - *track.doubted < kDoubtLasts;
  const bool known = track.count >= kKnown;
  if (known && track.unusable > kFaultyShare)
    return say(faulty, doubted ? std::string_view(track.doubt) : "most of it is unusable");
  if (known && track.gated > kFaultyShare)
    return say(faulty, doubted ? std::string_view(track.doubt) : "most of it is gated");
  if (doubted) return say(degraded, track.doubt);
  if (known && track.unusable > kDegradedShare) return say(degraded, "some of it is unusable");
  if (known && track.gated > kDegradedShare) return say(degraded, "some of it is gated");
  if (is_not_localized(track)) return say(degraded, "most of its scans do not localise the robot in the loaded map");
  if (track.count >= kWindow && track.nis_ratio > kDegradedNis) return say(degraded, "its innovations are too large");
  return say(ok, "");
}

/// If the innovations of absolute sensors are r times as large (squared) as predicted, so, at worst, is the error of
/// the pose behind them.
double HealthMonitor::off_probability() const {
  double ratio = 1.0;
  for (const Track& track : sensors_) {
    if (track.role.ties_to_map && track.count >= kKnown) ratio = std::max(ratio, track.nis_ratio);
  }
  return std::exp(-0.5 * kThreeSigmaSquared / ratio);
}

void HealthMonitor::judge(Time now, double position_sigma) {
  bool motion = motion_from_maps_;
  bool tied = false;
  bool any_ties = false;
  std::size_t worst = sensors_.size();
  for (std::size_t i = 0; i < sensors_.size(); ++i) {
    const Track& track = sensors_[i];
    judge_sensor(track, now, health_.sensors[i]);
    const SensorHealth::State state = health_.sensors[i].state;
    const bool serves = state == SensorHealth::State::ok || state == SensorHealth::State::degraded;
    if (track.role.fused && track.role.is_motion_source) motion = motion || serves;
    if (track.role.fused && track.role.ties_to_map) {
      any_ties = true;
      const Time since = track.last_good.value_or(started_.value_or(now));
      tied = tied || now - since <= settings_.unaided_after;
    }
    if (state != SensorHealth::State::ok && (worst == sensors_.size() || state > health_.sensors[worst].state))
      worst = i;
  }
  health_.probability_off_3_sigma = off_probability();

  using enum Health::State;
  const auto say = [&](Health::State state, std::string_view why) {
    settle(health_.state, state, health_.reason, why);
  };
  if (!motion) return say(lost, "no motion source delivers");
  if (position_sigma > settings_.lost_sigma) return say(lost, "the position is too uncertain");
  if (reacquired_ && now - *reacquired_ < kAfterReacquisition) {
    return say(lost, "the belief was wrong and has just been widened");
  }
  if (any_ties && !tied) return say(degraded, "dead reckoning: nothing ties the robot to the map any more");
  if (worst == sensors_.size()) return say(ok, "");
  const SensorHealth& culprit = health_.sensors[worst];
  fmt::memory_buffer why;  // on the stack
  fmt::format_to(std::back_inserter(why), "{} is {}: {}", sensors_[worst].role.name, to_string(culprit.state),
                 culprit.reason);
  say(degraded, {why.data(), why.size()});
}

}  // namespace waymark::monitoring
