// SPDX-License-Identifier: Apache-2.0
#include "course.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "streams.hpp"

namespace waymark::simulator {
namespace {

constexpr double kShortestLeg = 0.01;  // [m]
constexpr double kTargetStep = 0.001;  // [m], how finely the pursued point moves along the course
constexpr double kArrived = 0.001;     // [m]
constexpr double kPathSpacing = 0.1;   // [m]
constexpr double kSwingPeriodSeconds = 20.0;

/// The pose after `dt` at constant twist; exact (the SE(2) exponential), with its series where the arc is nearly
/// straight.
Motion advance(const Motion& from, double dt) {
  const double turn = from.w * dt;
  const bool straight = std::abs(turn) < 1e-6;
  const double along = straight ? 1.0 - turn * turn / 6.0 : std::sin(turn) / turn;
  const double across = straight ? 0.5 * turn : (1.0 - std::cos(turn)) / turn;
  const double forward = dt * (along * from.v_x - across * from.v_y);
  const double left = dt * (across * from.v_x + along * from.v_y);
  Motion to = from;
  to.x += std::cos(from.yaw) * forward - std::sin(from.yaw) * left;
  to.y += std::sin(from.yaw) * forward + std::cos(from.yaw) * left;
  to.yaw = so3::wrap(from.yaw + turn);
  return to;
}

}  // namespace

Course::Course(const Config& config)
    : laps_(static_cast<int>(config.integer_in({"laps", "how often the course is driven"}, 1, 10000, 1))) {
  const std::vector<double> numbers =
      config.numbers({"waypoints_m", "m", "x, y of one way point after the other, one flat list"});
  if (numbers.size() < 4 || numbers.size() % 2 != 0) {
    config.fail("waypoints_m", fmt::format("{} numbers; x, y of at least two way points are expected", numbers.size()));
  }
  for (std::size_t i = 0; i < numbers.size(); i += 2) corners_.emplace_back(numbers[i], numbers[i + 1]);
  const bool closed = config.boolean(
      {"closed", "", "the course leads back to the first way point", "true from three points on"}, corners_.size() > 2);
  if (closed && (corners_.front() - corners_.back()).norm() >= kShortestLeg) corners_.push_back(corners_.front());
  if (!closed && laps_ > 1) config.fail("laps", fmt::format("{} laps of a course that is not closed", laps_));

  arc_length_.push_back(0.0);
  for (std::size_t i = 1; i < corners_.size(); ++i) {
    const double leg = (corners_[i] - corners_[i - 1]).norm();
    if (leg < kShortestLeg) {
      config.fail("waypoints_m", fmt::format("way points {} and {} are the same place", i, i + 1));
    }
    arc_length_.push_back(arc_length_.back() + leg);
  }
  lap_length_ = arc_length_.back();
}

Course Course::limited_to(int laps) const {
  Course course = *this;
  course.laps_ = std::min(laps, laps_);
  return course;
}

Eigen::Vector2d Course::point(double s) const {
  const double lap = std::clamp(std::floor(s / lap_length_), 0.0, static_cast<double>(laps_ - 1));
  const double within = std::clamp(s - lap * lap_length_, 0.0, lap_length_);
  const auto next = std::upper_bound(arc_length_.begin() + 1, arc_length_.end() - 1, within);
  const auto leg = static_cast<std::size_t>(next - arc_length_.begin());
  const double share = (within - arc_length_[leg - 1]) / (arc_length_[leg] - arc_length_[leg - 1]);
  return corners_[leg - 1] + share * (corners_[leg] - corners_[leg - 1]);
}

Pose Course::start() const {
  const Eigen::Vector2d ahead = corners_[1] - corners_[0];
  return Pose::planar(corners_[0].x(), corners_[0].y(), std::atan2(ahead.y(), ahead.x()));
}

Eigen::Vector2d velocity(const Motion& motion, const Eigen::Vector3d& p_base) {
  const double forward = motion.v_x - motion.w * p_base.y();
  const double left = motion.w * p_base.x();
  const double c = std::cos(motion.yaw);
  const double s = std::sin(motion.yaw);
  return {c * forward - s * left, s * forward + c * left};
}

Motion Trajectory::at(Duration time) const {
  const std::int64_t step = time / kStep;
  if (step >= static_cast<std::int64_t>(steps_.size())) return steps_.back();
  return advance(steps_[static_cast<std::size_t>(step)], to_seconds(time % kStep));
}

Trajectory drive(const Course& course, const DriveLimits& limits, Duration duration, std::uint64_t seed) {
  const double dt = to_seconds(Trajectory::kStep);
  const Pose start = course.start();
  Motion now{start.p.x(), start.p.y(), start.yaw(), 0.0, 0.0, 0.0};
  double target = 0.0;
  std::vector<Motion> steps;
  for (Duration time{0}; time <= duration; time += Trajectory::kStep) {
    const Eigen::Vector2d p(now.x, now.y);
    while (target < course.length() && (course.point(target) - p).norm() < limits.lookahead_m) target += kTargetStep;
    const bool ending = target >= course.length();
    const Eigen::Vector2d to_target = course.point(std::min(target, course.length())) - p;
    const double ahead = std::cos(now.yaw) * to_target.x() + std::sin(now.yaw) * to_target.y();
    const double aside = std::cos(now.yaw) * to_target.y() - std::sin(now.yaw) * to_target.x();
    if (ending && ahead < kArrived) break;

    const double phase = 2.0 * std::numbers::pi * to_seconds(time) / kSwingPeriodSeconds;
    const double cruise = limits.speed_mps * (1.0 - 0.5 * limits.speed_swing * (1.0 - std::cos(phase)));
    double speed = std::min(now.v_x + limits.acceleration_mps2 * dt, cruise);
    if (ending) speed = std::min(speed, std::sqrt(2.0 * limits.acceleration_mps2 * ahead));
    // The end of the course comes nearer than any other target, but no robot turns on the spot for its last centimetre.
    const double reach = std::max(to_target.norm(), limits.lookahead_m);
    const double curvature = 2.0 * aside / (reach * reach);
    now.v_x = speed;
    now.v_y = 0.0;
    now.w = std::clamp(curvature * speed, -limits.turn_rate_radps, limits.turn_rate_radps);
    if (limits.slip_m_per_sqrt_s > 0.0) {
      now.v_y = limits.slip_m_per_sqrt_s / std::sqrt(dt) * stream(seed, Draw::slip, time).normal();
    }
    steps.push_back(now);
    now = advance(now, dt);
  }
  now.v_x = now.v_y = now.w = 0.0;
  steps.push_back(now);
  return Trajectory(std::move(steps));
}

std::vector<Eigen::Vector2d> nominal_path(const Course& course, const DriveLimits& limits) {
  DriveLimits nominal = limits;
  nominal.slip_m_per_sqrt_s = 0.0;
  // Two laps show every corner, also the one between laps. The limit in time is generous: the pursuit ends by itself.
  const Course laps = course.limited_to(2);
  const double longest_s =
      60.0 + 3.0 * laps.length() / limits.speed_mps + 4.0 * limits.speed_mps / limits.acceleration_mps2;
  const Trajectory trajectory = drive(laps, nominal, from_seconds(longest_s), 0);
  std::vector<Eigen::Vector2d> path;
  for (const Motion& motion : trajectory.steps()) {
    const Eigen::Vector2d p(motion.x, motion.y);
    if (path.empty() || (p - path.back()).norm() >= kPathSpacing) path.push_back(p);
  }
  return path;
}

}  // namespace waymark::simulator
