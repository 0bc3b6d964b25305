// SPDX-License-Identifier: Apache-2.0
#include "monitoring/health_monitor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
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
/// Of scans that contradict the map where they were expected: at most 0.55 of the last 20 on right maps, of a scanner
/// that turns by up to 48 degrees between two scans, and 0.25 on those of planar ones; 0.9 to 1 where the map cannot
/// represent what is seen.
constexpr double kSearchedShare = 0.6;
/// One scan alone that fits nowhere may have been of a person in front of the scanner.
constexpr std::uint64_t kManyTears = 2;
/// Limit of the mean NIS over its degrees of freedom; above it a sensor's noise, or the belief, is inconsistent. For
/// one degree of freedom and the window, χ² exceeds it with probability 10⁻⁴.
constexpr double kDegradedNis = 2.5;
constexpr Duration kSilence = std::chrono::seconds(1);  // at least; for slow sensors several of their intervals
constexpr double kSilentIntervals = 5.0;
/// The clock goes on by no more than this from one measurement to the next, or by three usual steps: a longer one is a
/// pause of the log.
constexpr double kLongestStep = 0.5;
constexpr double kUsualSteps = 3.0;
constexpr Duration kNeverDelivered = std::chrono::seconds(10);
constexpr Duration kAfterReacquisition = std::chrono::seconds(5);
constexpr Duration kDegradedFor = std::chrono::seconds(2);
/// An attitude that is less certain than this (σ) is as good as not observed.
constexpr double kUnknownTilt = 0.17;  // [rad], 10°
/// P(χ² with two degrees of freedom > 9) = exp(−9 / 2): outside the 3σ ellipse of a consistent covariance.
constexpr double kThreeSigmaSquared = 9.0;

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

void HealthMonitor::start(Time stamp) {
  advance(stamp);
  started_ = clock_;
  judged_ = clock_;
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
  advance(stamp);
  began_anew_ = clock_;
  started_ = clock_;
}

void HealthMonitor::advance(Time now) {
  if (newest_ && now > *newest_) {
    const double passed = to_seconds(now - *newest_);
    const double step = std::min(passed, std::max(kLongestStep, kUsualSteps * step_));
    step_ += (step_ == 0.0 ? 1.0 : 1.0 / kWindow) * (step - step_);
    clock_ += from_seconds(step);
  }
  newest_ = std::max(newest_.value_or(now), now);
}

void HealthMonitor::record(std::size_t index, Time stamp, const UpdateResult& result) {
  advance(stamp);
  add(sensors_[index], result);
}

void HealthMonitor::add(Track& track, const UpdateResult& result) {
  if (track.last && clock_ > *track.last) {
    const double dt = to_seconds(clock_ - *track.last);
    track.interval += (track.interval == 0.0 ? 1.0 : 1.0 / kWindow) * (dt - track.interval);
  }
  track.last = clock_;
  if (result.fate == Fate::held_out || result.fate == Fate::ignored || result.fate == Fate::before_start) return;
  track.observes_position = track.observes_position || result.observes_position;
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
    const auto add_to = [&](double& running_share, bool counts) {
      running_share += (1.0 / track.steps) * ((counts ? 1.0 : 0.0) - running_share);
    };
    add_to(track.not_localized, !*result.localized);
    add_to(track.not_matched, result.match_failed);
    add_to(track.contradicted, result.match_failed && result.match_searched);
    add_to(track.searched, result.match_searched);
    if (!track.role.has_prior_map) track.suspected_tears = result.suspected_tears;
  }
  // A scan that no map used leaves the localization as it was.
  if (usable(result.fate) && result.fate != Fate::gated && track.localized) track.last_good = track.last;
  if (!result.degraded_reason.empty()) {
    if (track.degraded_reason != result.degraded_reason) track.degraded_reason = result.degraded_reason;
    track.degraded_at = clock_;
  }
}

void HealthMonitor::mistimed(std::size_t index) {
  add(sensors_[index], {.fate = Fate::mistimed, .degraded_reason = "its stamps are implausible"});
}

void HealthMonitor::degrade(std::size_t index, Time stamp, std::string_view why) {
  advance(stamp);
  sensors_[index].degraded_reason = why;
  sensors_[index].degraded_at = clock_;
}

void HealthMonitor::dropped(std::size_t index, Time stamp) {
  degrade(index, stamp, "measurements are dropped: the filter does not keep up");
}

void HealthMonitor::missing(std::size_t index, Time stamp) {
  degrade(index, stamp, "measurements are missing: a gap in its stamps");
}

bool HealthMonitor::is_not_localized(const Track& track) {
  return track.role.has_prior_map && track.steps >= kKnown && track.not_localized > kFaultyShare;
}

HealthMonitor::Verdict<SensorHealth::State> HealthMonitor::judge_sensor(const Track& track) const {
  using enum SensorHealth::State;
  if (track.broken) return {faulty, "out of service", true};
  if (!track.role.fused) return {};
  if (!track.last) {
    if (started_ && clock_ - *started_ > kNeverDelivered) return {silent, "has never delivered", true};
    return {};
  }
  const Duration patience = std::max(kSilence, from_seconds(kSilentIntervals * track.interval));
  if (clock_ - *track.last > patience) return {silent, "has stopped", true};
  const bool reported = track.degraded_at && clock_ - *track.degraded_at < kDegradedFor;
  const bool known = track.count >= kKnown;
  if (known && track.unusable > kFaultyShare)
    return {faulty, reported ? std::string_view(track.degraded_reason) : "most of it is unusable"};
  if (known && track.gated > kFaultyShare)
    return {faulty, reported ? std::string_view(track.degraded_reason) : "most of it is gated"};
  if (reported) return {degraded, track.degraded_reason, true};
  if (known && track.unusable > kDegradedShare) return {degraded, "some of it is unusable"};
  if (known && track.gated > kDegradedShare) return {degraded, "some of it is gated"};
  if (is_not_localized(track)) return {degraded, "most of its scans do not localise the robot in the loaded map"};
  if (track.steps >= kKnown && track.not_matched > kFaultyShare)
    return {degraded, "most of its scans do not fit the map"};
  if (track.steps >= kWindow && track.contradicted > kDegradedShare)
    return {degraded, "some of its scans do not fit the map"};
  if (track.steps >= kWindow && track.searched > kSearchedShare)
    return {degraded, "most of its scans do not fit the map where the robot is expected"};
  if (track.suspected_tears >= kManyTears)
    return {degraded, "scans were written at poses that may be wrong: the map may be torn"};
  if (track.count >= kWindow && track.nis_ratio > kDegradedNis) return {degraded, "its innovations are too large"};
  return {};
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

/// Without an absolute position and a loaded map, the position is relative to the start by design: that it becomes
/// uncertain is no fault. An absolute sensor that has not delivered yet may be one of positions.
bool HealthMonitor::is_position_observed() const {
  return std::ranges::any_of(sensors_, [](const Track& track) {
    const bool may_observe = track.role.has_prior_map || track.observes_position || !track.last;
    return track.role.fused && track.role.is_aiding && may_observe;
  });
}

HealthMonitor::Verdict<Health::State> HealthMonitor::judge_pose(const Uncertainty& sigma, fmt::memory_buffer& text) {
  bool motion = motion_from_maps_;
  bool is_aided = false;
  bool has_aiding = false;
  bool has_map = false;
  std::size_t worst = sensors_.size();
  for (std::size_t i = 0; i < sensors_.size(); ++i) {
    const Track& track = sensors_[i];
    const SensorHealth::State state = health_.sensors[i].state;
    const bool serves = state == SensorHealth::State::ok || state == SensorHealth::State::degraded;
    if (track.role.fused && track.role.is_motion_source) motion = motion || serves;
    if (track.role.fused && track.role.is_aiding) {
      has_aiding = true;
      has_map = has_map || track.role.localizes;
      const Time since = track.last_good.value_or(started_.value_or(clock_));
      is_aided = is_aided || clock_ - since <= settings_.unaided_after;
    }
    if (state != SensorHealth::State::ok && (worst == sensors_.size() || state > health_.sensors[worst].state))
      worst = i;
  }
  using enum Health::State;
  if (searching_) return {lost, "position and heading are found anew", true};
  if (placement_ == Placement::misplaced)
    return {lost, "what the robot sees does not fit the loaded map where it is believed to be", true};
  if (placement_ == Placement::ambiguous)
    return {lost, "what the robot sees does not single out a place of the loaded map", true};
  if (began_anew_ && clock_ - *began_anew_ < kAfterReacquisition)
    return {lost, "position and heading began anew", true};
  if (reacquired_ && clock_ - *reacquired_ < kAfterReacquisition)
    return {lost, "the covariance was inflated to re-acquire a sensor", true};
  if (!motion) return {lost, "no motion source delivers"};
  // A pose that was lost once stays so until something has narrowed it.
  if (sigma.position > settings_.lost_sigma && (is_position_observed() || began_anew_))
    return {lost, "the position is too uncertain"};
  if (sigma.position > settings_.lost_sigma && has_map)
    return {degraded, "in new places: the position against the start is uncertain"};
  if (particles_alone_) return {degraded, "the joint Gaussian was given up: the covariance is too small"};
  if (modes_ > 1) return {degraded, "the particles have the robot at more than one place"};
  if (placement_ == Placement::doubtful)
    return {degraded, "what the robot sees fits the loaded map worse than usual", true};
  // Where nothing observes the position at all, the robot is judged by what is observed.
  if (sigma.height > settings_.lost_sigma && sigma.position <= settings_.lost_sigma)
    return {degraded, "the height is too uncertain"};
  if (sigma.tilt > kUnknownTilt) return {degraded, "roll and pitch are too uncertain"};
  if (has_aiding && !is_aided) return {degraded, "dead reckoning: no absolute sensor or map corrects the position"};
  if (worst == sensors_.size()) return {};
  const SensorHealth& worst_health = health_.sensors[worst];
  fmt::format_to(std::back_inserter(text), "{} is {}: {}", sensors_[worst].role.name, to_string(worst_health.state),
                 worst_health.reason);
  return {degraded, {text.data(), text.size()}, true};  // the sensor's state has settled already
}

void HealthMonitor::count_time() {
  const double passed = to_seconds(clock_ - judged_);
  judged_ = clock_;
  double& time = health_.state == Health::State::ok         ? times_.ok_s
                 : health_.state == Health::State::degraded ? times_.degraded_s
                                                            : times_.lost_s;
  time += passed;
}

void HealthMonitor::judge(Time now, const Uncertainty& sigma) {
  advance(now);
  count_time();
  for (std::size_t i = 0; i < sensors_.size(); ++i) {
    const auto verdict = judge_sensor(sensors_[i]);
    SensorHealth& health = health_.sensors[i];
    sensors_[i].settled.settle(verdict.state, verdict.why, verdict.is_certain, clock_, health.state, health.reason);
  }
  health_.probability_off_3_sigma = off_probability();
  fmt::memory_buffer text;  // on the stack
  const auto verdict = judge_pose(sigma, text);
  settled_.settle(verdict.state, verdict.why, verdict.is_certain, clock_, health_.state, health_.reason);
}

}  // namespace waymark::monitoring
