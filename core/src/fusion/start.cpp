// SPDX-License-Identifier: Apache-2.0
// Before the start: measurements are buffered until start pose and first motion measurement are known, then processed
// in order. The same after the pose was lost.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "estimation/ekf.hpp"
#include "fusion/parts.hpp"
#include "waymark/base/error.hpp"
#include "waymark/math/so3.hpp"

namespace waymark {

void Fusion::Parts::await_start(const Measurement& m) {
  committed.last_stamp = std::max(committed.last_stamp, m.stamp);
  const auto hint = startup.needs_pose() ? steps.start_hint(m) : std::nullopt;
  if (const auto start = startup.process(m, hint, committed.sensors)) begin(*start);
}

void Fusion::Parts::begin(const fusion::Start& start) {
  if (started) {
    begin_anew(start);
  } else {
    committed.filter.start(start.prior, start.draw, start.frame);
    committed.health.start(start.prior.stamp);
    started = true;
  }
  committed.filter.reported();  // `front` may be called before the first commit
  for (const Measurement& m : startup.release()) {
    if (searching) {
      await_start(m);  // a gap between the buffered measurements
      continue;
    }
    const bool before = m.stamp < start.prior.stamp;
    // Alternation and stretches count from its first measurement.
    if (before) committed.record(m).state.fuse.fuses(m.stamp);
    if (start.used && m.sensor == start.used_sensor && m.sequence == start.used_sequence) {
      committed.count(m, Fate::fused);  // used for the start pose
      notify_observer(m, Fate::fused);
    } else if (before) {
      committed.count(m, Fate::before_start);
      notify_observer(m, Fate::before_start);
    } else {
      commit(m);
    }
  }
}

/// Increments measure the motion between two stamps, however long that is, unless the clock was set in between.
bool Fusion::Parts::is_after_gap(const Measurement& m) const {
  const Duration gap = m.stamp - committed.filter.stamp();
  return gap > settings.clock.max_gap && (gap > settings.clock.max_jump || !committed.standstill.is_known_until_next());
}

/// The last pose, in case that nothing finds another one: anywhere around it, with any heading.
fusion::Start Fusion::Parts::last_pose(Time at) const {
  constexpr double kLostSigmas = 2.0;
  const double position_sigma = std::max(kLostSigmas * settings.health.lost_sigma, settings.start.position_sigma);
  const double yaw_sigma = std::numbers::pi / std::numbers::sqrt3;  // of a uniform distribution
  const auto& pose = layout.pose_indices();
  fusion::Start start;
  start.keeps_pose = true;
  start.prior.stamp = at;
  start.prior.mean.block.setZero(layout.block_size());
  start.prior.P.setZero(layout.size(), layout.size());
  estimation::ekf::release(start.prior, layout, settings.start.velocity_sigma, settings.start.rate_sigma);
  start.prior.P(pose[0], pose[0]) = start.prior.P(pose[1], pose[1]) = position_sigma * position_sigma;
  start.prior.P(pose[2], pose[2]) = yaw_sigma * yaw_sigma;
  return start;
}

/// A prediction up to here has no information about the time after a gap, and an estimate with an invalid covariance
/// has none at all. Maps and the sensors' own states stay.
void Fusion::Parts::lose_pose(Time at, const std::string& why) {
  committed.note(at, why + ": the pose is lost; position, heading and twist are found anew, as at the start");
  searching = true;
  committed.unsound = false;
  // Until then the last pose stands, so that the results of a run that ends here are not those of a broken filter.
  committed.filter.begin_anew({last_pose(committed.filter.stamp()).prior, true});
  committed.filter.reported();
  startup.search_again(last_pose(at), settings.clock.max_gap, !maps.empty());
  history.clear();
  committed.health.search();
  committed.update_health(at);
}

void Fusion::Parts::begin_anew(const fusion::Start& start) {
  searching = false;
  committed.filter.begin_anew({start.prior, start.keeps_pose});
  committed.standstill.reset();
  committed.health.begin_anew(start.prior.stamp);
  for (fusion::SensorRecord& sensor : committed.sensors) {
    sensor.state.rejections_in_a_row.fill(0);
    sensor.state.bias.reset();
  }
  if (settings.smooth) committed.smoother.cut_next();
  committed.note(start.prior.stamp,
                 start.keeps_pose ? "no sensor found the pose anew: the filter goes on from the last one, with a wide "
                                    "covariance"
                                  : "position and heading were found anew");
}

/// The last pose, moved to another place in the plane, with its covariance.
fusion::Start Fusion::Parts::start_at(Time at, const Eigen::Vector3d& xyyaw, const Eigen::Matrix3d& P) const {
  fusion::Start start = last_pose(at);
  start.keeps_pose = false;
  const Pose& before = committed.filter.mixture().mean.T_map_base;
  const Eigen::Quaterniond turn = so3::from_rpy(0.0, 0.0, xyyaw.z() - before.yaw());
  start.prior.mean.T_map_base = {turn * before.q, {xyyaw.x(), xyyaw.y(), before.p.z()}};
  const auto& index = layout.pose_indices();
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) start.prior.P(index[i], index[k]) = P(i, k);
  }
  return start;
}

/// The robot was searched for in a loaded map, and found.
void Fusion::Parts::begin_at(Time at, const relocation::Place& place) {
  committed.note(at, fmt::format("the robot was found in the loaded map, at x {:.2f} m, y {:.2f} m, heading {:.1f}°",
                                 place.xyyaw.x(), place.xyyaw.y(), place.xyyaw.z() * 180.0 / std::numbers::pi));
  history.clear();
  begin_anew(start_at(at, place.xyyaw, place.P));
}

void Fusion::set_pose(const GivenPose& pose) {
  Parts& p = *parts_;
  // As those of `initial`: farther away doubles are too coarse, and no fix would be believed.
  constexpr double kFarthest = 1e8;
  constexpr double kLargestSigma = 1e7;
  constexpr double kLeastSigma = 1e-6;
  const auto is_sigma = [](double sigma, double most) { return sigma >= kLeastSigma && sigma <= most; };
  const bool is_valid = pose.position.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() <= kFarthest &&
                        std::isfinite(pose.yaw) && is_sigma(pose.position_sigma, kLargestSigma) &&
                        is_sigma(pose.yaw_sigma, std::numbers::pi);
  if (!is_valid) {
    throw Error(
        fmt::format("a pose needs x and y within {:.0e} m, a finite heading, and a σ of the position of {:.0e} to "
                    "{:.0e} m and of the heading of {:.0e} to π rad",
                    kFarthest, kLeastSigma, kLargestSigma, kLeastSigma));
  }
  if (!p.started) return p.startup.give(pose);
  const double variance = pose.position_sigma * pose.position_sigma;
  const fusion::Start start =
      p.start_at(p.committed.filter.stamp(), {pose.position.x(), pose.position.y(), pose.yaw},
                 Eigen::Vector3d(variance, variance, pose.yaw_sigma * pose.yaw_sigma).asDiagonal());
  p.committed.note(start.prior.stamp,
                   fmt::format("the pose was set to x {:.3f} m, y {:.3f} m, heading {:.1f}°", pose.position.x(),
                               pose.position.y(), pose.yaw * 180.0 / std::numbers::pi));
  p.history.clear();
  if (p.searching) {
    p.begin(start);
  } else {
    p.begin_anew(start);
    p.committed.filter.reported();
  }
}

void Fusion::finish() {
  Parts& p = *parts_;
  p.intake.finish([&](const Measurement& m, bool is_late) { p.dispatch(m, is_late); });
  if (p.has_pose()) {
    p.committed.filter.finish_correction();
    p.committed.note_closed_loop(p.committed.last_stamp);
    p.committed.filter.reported();
    return;
  }
  for (const Measurement& m : p.startup.release()) {
    p.committed.count(m, Fate::before_start);
    if (p.started) p.notify_observer(m, Fate::before_start);
  }
  if (p.started) {
    p.committed.note(p.committed.last_stamp, "the pose was lost and not found again: " + p.startup.missing());
    p.committed.events.back().is_failure = true;
    return;
  }
  p.committed.note(p.committed.last_stamp, "the filter never started: " +
                                               (p.arrived == 0 ? "no measurement has arrived" : p.startup.missing()));
}

}  // namespace waymark
