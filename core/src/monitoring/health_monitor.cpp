// SPDX-License-Identifier: Apache-2.0
#include "monitoring/health_monitor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "waymark/base/error.hpp"

namespace waymark::monitoring {

namespace {

/// Window of running shares and means, in measurements of a sensor: short enough to detect a fault within seconds, long
/// enough to tolerate one outlier.
constexpr double kWindow = 20.0;
constexpr double kKnown = 5.0;  // measurements from which a share is significant
constexpr double kDegradedShare = 0.15;
constexpr double kFaultyShare = 0.5;
/// Limit of the mean NIS over its degrees of freedom; above it a sensor's noise, or the belief, is inconsistent. For
/// one degree of freedom and the window, χ² exceeds it with probability 10⁻⁴.
constexpr double kDegradedNis = 2.5;
constexpr Duration kSilence = std::chrono::seconds(1);  // at least; for slow sensors several of their intervals
constexpr double kSilentIntervals = 5.0;
constexpr Duration kNeverDelivered = std::chrono::seconds(10);
constexpr Duration kAfterReacquisition = std::chrono::seconds(5);
constexpr Duration kDegradedFor = std::chrono::seconds(2);
/// P(χ² with two degrees of freedom > 9) = exp(−9 / 2): outside the 3σ ellipse of a consistent covariance.
constexpr double kThreeSigmaSquared = 9.0;

/// Assigns the text only if it changes: called thousands of times a second, and a copy allocates.
template <class State>
void set_state(State& state, State to, std::string& reason, std::string_view why) {
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

void HealthMonitor::search() {
  searching_ = true;
  // The gap is not an interval between two measurements of a sensor.
  for (Track& track : sensors_) {
    track.last.reset();
    track.last_good.reset();
    track.degraded_at.reset();
  }
}

void HealthMonitor::begin_anew(Time stamp) {
  searching_ = false;
  began_anew_ = stamp;
  started_ = stamp;
}

void HealthMonitor::record(std::size_t index, Time stamp, const UpdateResult& result) {
  Track& track = sensors_[index];
  if (track.last && stamp > *track.last) {
    const double dt = to_seconds(stamp - *track.last);
    track.interval += (track.interval == 0.0 ? 1.0 : 1.0 / kWindow) * (dt - track.interval);
  }
  track.last = std::max(track.last.value_or(stamp), stamp);
  if (result.fate == Fate::held_out || result.fate == Fate::ignored || result.fate == Fate::before_start) return;
  track.count = std::min(track.count + 1.0, kWindow);
  const double share = 1.0 / track.count;
  track.gated += share * ((result.fate == Fate::gated ? 1.0 : 0.0) - track.gated);
  track.unusable += share * ((usable(result.fate) ? 0.0 : 1.0) - track.unusable);
  if (result.dof > 0) {
    // Gated updates count, but clamped: one fix 800 m off must not dominate the mean for minutes.
    constexpr double kClamp = 12.0;
    track.nis_ratio += share * (std::min(result.nis / result.dof, kClamp) - track.nis_ratio);
  }
  if (result.localized) {
    track.was_localized = track.was_localized || *result.localized;
    track.localized = *result.localized || !(track.was_localized || track.role.has_prior_map);
    track.steps = std::min(track.steps + 1.0, kWindow);
    track.not_localized += (1.0 / track.steps) * ((*result.localized ? 0.0 : 1.0) - track.not_localized);
  }
  // A scan that no map used leaves the localization as it was.
  if (usable(result.fate) && result.fate != Fate::gated && track.localized) track.last_good = track.last;
  if (!result.degraded_reason.empty()) {
    if (track.degraded_reason != result.degraded_reason) track.degraded_reason = result.degraded_reason;
    track.degraded_at = stamp;
  }
}

void HealthMonitor::mistimed(std::size_t index, Time stamp) {
  record(index, sensors_[index].last.value_or(stamp),
         {.fate = Fate::mistimed, .degraded_reason = "its stamps are implausible"});
}

void HealthMonitor::dropped(std::size_t index, Time stamp) {
  sensors_[index].degraded_reason = "measurements are dropped: the filter does not keep up";
  sensors_[index].degraded_at = stamp;
}

bool HealthMonitor::is_not_localized(const Track& track) {
  return track.role.has_prior_map && track.steps >= kKnown && track.not_localized > kFaultyShare;
}

void HealthMonitor::judge_sensor(const Track& track, Time now, SensorHealth& health) const {
  using enum SensorHealth::State;
  const auto set = [&](SensorHealth::State state, std::string_view why) {
    set_state(health.state, state, health.reason, why);
  };
  if (track.broken) return set(faulty, "out of service");
  if (!track.role.fused) return set(ok, "");
  if (!track.last) {
    if (started_ && now - *started_ > kNeverDelivered) return set(silent, "has never delivered");
    return set(ok, "");
  }
  const Duration patience = std::max(kSilence, from_seconds(kSilentIntervals * track.interval));
  if (now - *track.last > patience) return set(silent, "has stopped");
  const bool reported = track.degraded_at && now - *track.degraded_at < kDegradedFor;
  const bool known = track.count >= kKnown;
  if (known && track.unusable > kFaultyShare)
    return set(faulty, reported ? std::string_view(track.degraded_reason) : "most of it is unusable");
  if (known && track.gated > kFaultyShare)
    return set(faulty, reported ? std::string_view(track.degraded_reason) : "most of it is gated");
  if (reported) return set(degraded, track.degraded_reason);
  if (known && track.unusable > kDegradedShare) return set(degraded, "some of it is unusable");
  if (known && track.gated > kDegradedShare) return set(degraded, "some of it is gated");
  if (is_not_localized(track)) return set(degraded, "most of its scans do not localise the robot in the loaded map");
  if (track.count >= kWindow && track.nis_ratio > kDegradedNis) return set(degraded, "its innovations are too large");
  return set(ok, "");
}

/// If the squared innovations of absolute sensors are r times as large as predicted, so, at worst, is the squared error
/// of the pose.
double HealthMonitor::off_probability() const {
  double ratio = 1.0;
  for (const Track& track : sensors_) {
    if (track.role.is_aiding && track.count >= kKnown) ratio = std::max(ratio, track.nis_ratio);
  }
  return std::exp(-0.5 * kThreeSigmaSquared / ratio);
}

void HealthMonitor::judge(Time now, double position_sigma) {
  bool motion = motion_from_maps_;
  bool is_aided = false;
  bool has_aiding = false;
  std::size_t worst = sensors_.size();
  for (std::size_t i = 0; i < sensors_.size(); ++i) {
    const Track& track = sensors_[i];
    judge_sensor(track, now, health_.sensors[i]);
    const SensorHealth::State state = health_.sensors[i].state;
    const bool serves = state == SensorHealth::State::ok || state == SensorHealth::State::degraded;
    if (track.role.fused && track.role.is_motion_source) motion = motion || serves;
    if (track.role.fused && track.role.is_aiding) {
      has_aiding = true;
      const Time since = track.last_good.value_or(started_.value_or(now));
      is_aided = is_aided || now - since <= settings_.unaided_after;
    }
    if (state != SensorHealth::State::ok && (worst == sensors_.size() || state > health_.sensors[worst].state))
      worst = i;
  }
  health_.probability_off_3_sigma = off_probability();

  using enum Health::State;
  const auto set = [&](Health::State state, std::string_view why) {
    set_state(health_.state, state, health_.reason, why);
  };
  if (searching_) return set(lost, "position and heading are found anew");
  if (!motion) return set(lost, "no motion source delivers");
  if (position_sigma > settings_.lost_sigma) return set(lost, "the position is too uncertain");
  if (began_anew_ && now - *began_anew_ < kAfterReacquisition) return set(lost, "position and heading began anew");
  if (reacquired_ && now - *reacquired_ < kAfterReacquisition) {
    return set(lost, "the covariance was inflated to re-acquire a sensor");
  }
  if (has_aiding && !is_aided) return set(degraded, "dead reckoning: no absolute sensor or map corrects the position");
  if (worst == sensors_.size()) return set(ok, "");
  const SensorHealth& worst_health = health_.sensors[worst];
  fmt::memory_buffer why;  // on the stack
  fmt::format_to(std::back_inserter(why), "{} is {}: {}", sensors_[worst].role.name, to_string(worst_health.state),
                 worst_health.reason);
  set(degraded, {why.data(), why.size()});
}

}  // namespace waymark::monitoring
