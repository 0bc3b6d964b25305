// SPDX-License-Identifier: Apache-2.0
#include "course.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "streams.hpp"

namespace waymark::simulator {
namespace {

constexpr double kShortestLeg = 0.01;  // [m]
constexpr double kTargetStep = 0.001;  // [m], how finely the pursued point moves along the course
constexpr double kArrived = 0.001;     // [m]
constexpr double kPathSpacing = 0.1;   // [m]
constexpr double kSwingPeriodSeconds = 20.0;
constexpr double kDrop = 0.01;  // [m]

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

/// The base's axes in the map as columns, and how they change.
struct Axes {
  Eigen::Matrix3d R;
  Eigen::Matrix3d R_dot;  // [1/s]
};

/// The direction of `v`, and how it changes as `v` does.
void normalize(const Eigen::Vector3d& v, const Eigen::Vector3d& v_dot, Eigen::Ref<Eigen::Vector3d> out,
               Eigen::Ref<Eigen::Vector3d> out_dot) {
  const double length = v.norm();
  out = v / length;
  out_dot = (v_dot - out * out.dot(v_dot)) / length;
}

/// Velocity of the base's origin in the map, which lies in the surface.
Eigen::Vector3d velocity_of_base(const Motion& motion) {
  const double c = std::cos(motion.yaw);
  const double s = std::sin(motion.yaw);
  const double x = c * motion.v_x - s * motion.v_y;
  const double y = s * motion.v_x + c * motion.v_y;
  return {x, y, motion.slope.z_x * x + motion.slope.z_y * y};
}

Axes axes(const Motion& motion) {
  const Slope& slope = motion.slope;
  const double c = std::cos(motion.yaw);
  const double s = std::sin(motion.yaw);
  const Eigen::Vector3d v = velocity_of_base(motion);
  const double z_x_dot = slope.z_xx * v.x() + slope.z_xy * v.y();
  const double z_y_dot = slope.z_xy * v.x() + slope.z_yy * v.y();
  Axes out;
  normalize({c, s, slope.z_x * c + slope.z_y * s},
            {-s * motion.w, c * motion.w, z_x_dot * c + z_y_dot * s + motion.w * (slope.z_y * c - slope.z_x * s)},
            out.R.col(0), out.R_dot.col(0));
  normalize({-slope.z_x, -slope.z_y, 1.0}, {-z_x_dot, -z_y_dot, 0.0}, out.R.col(2), out.R_dot.col(2));
  out.R.col(1) = out.R.col(2).cross(out.R.col(0));
  out.R_dot.col(1) = out.R_dot.col(2).cross(out.R.col(0)) + out.R.col(2).cross(out.R_dot.col(0));
  return out;
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

  start_height_m_ = config.number_in(
      {"start_height_m", "m", "the robot starts on the highest surface that is not above this"}, -1000.0, 1000.0, 0.0);

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

Pose Motion::pose() const {
  if (is_level) return Pose::planar(x, y, yaw);
  return {Eigen::Quaterniond(axes(*this).R), {x, y, slope.z}};
}

Eigen::Vector3d Motion::v_base() const {
  if (is_level) return {v_x, v_y, 0.0};
  Eigen::Vector3d v = axes(*this).R.transpose() * velocity_of_base(*this);
  v.z() = 0.0;  // but for rounding
  return v;
}

Eigen::Vector3d Motion::w_base() const {
  if (is_level) return {0.0, 0.0, w};
  const Axes now = axes(*this);
  const Eigen::Matrix3d W = now.R.transpose() * now.R_dot;
  return {W(2, 1), W(0, 2), W(1, 0)};
}

Eigen::Vector3d Motion::w_map() const {
  if (is_level) return {0.0, 0.0, w};
  return axes(*this).R * w_base();
}

Eigen::Vector3d velocity(const Motion& motion, const Eigen::Vector3d& p_base) {
  if (!motion.is_level) {
    Motion straight = motion;
    straight.v_y = 0.0;
    return velocity_of_base(straight) + axes(straight).R_dot * p_base;
  }
  const double forward = motion.v_x - motion.w * p_base.y();
  const double left = motion.w * p_base.x();
  const double c = std::cos(motion.yaw);
  const double s = std::sin(motion.yaw);
  return {c * forward - s * left, s * forward + c * left, 0.0};
}

Trajectory Trajectory::on(std::shared_ptr<const Ground> ground, double start_height_m) const {
  Trajectory out = *this;
  out.ground_ = std::move(ground);
  out.decks_.reserve(steps_.size());
  double z = start_height_m;
  bool is_start = true;
  for (Motion& step : out.steps_) {
    const Eigen::Vector2d p(step.x, step.y);
    // What it stood on goes on, so that a slope is no step.
    if (!is_start) z = out.ground_->at(out.decks_.back(), p).z;
    const std::optional<int> deck = out.ground_->below(p, z);
    if (!deck)
      throw std::domain_error(
          fmt::format("at ({:.2f}, {:.2f}), {:.2f} m high, it runs into the side of a ramp or floor", p.x(), p.y(), z));
    step.is_level = false;
    step.slope = out.ground_->at(*deck, p);
    if (!is_start && step.slope.z < z - kDrop)
      throw std::domain_error(fmt::format("at ({:.2f}, {:.2f}) it drives over an edge, from {:.2f} m down to {:.2f} m",
                                          p.x(), p.y(), z, step.slope.z));
    out.decks_.push_back(*deck);
    is_start = false;
  }
  return out;
}

Motion Trajectory::at(Duration time) const {
  const std::int64_t step = time / kStep;
  if (step >= static_cast<std::int64_t>(steps_.size())) return steps_.back();
  const auto index = static_cast<std::size_t>(step);
  Motion motion = advance(steps_[index], to_seconds(time % kStep));
  if (ground_) motion.slope = ground_->at(decks_[index], {motion.x, motion.y});
  return motion;
}

Trajectory drive(const Course& course, const DriveLimits& limits, Duration duration, std::uint64_t seed) {
  const double dt = to_seconds(Trajectory::kStep);
  const Pose start = course.start();
  Motion now{start.p.x(), start.p.y(), start.yaw(), 0.0, 0.0, 0.0};
  double target = 0.0;
  std::vector<Motion> steps;
  const Duration start_time = from_seconds(limits.start_s);
  for (Duration time{0}; time <= duration; time += Trajectory::kStep) {
    if (time < start_time) {
      steps.push_back(now);
      continue;
    }
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

std::vector<Eigen::Vector3d> nominal_path(const Course& course, const DriveLimits& limits,
                                          const std::shared_ptr<const Ground>& ground) {
  DriveLimits nominal = limits;
  nominal.slip_m_per_sqrt_s = 0.0;
  nominal.start_s = 0.0;
  // Two laps show every corner, also the one between laps. The limit in time is generous: the pursuit ends by itself.
  const Course laps = course.limited_to(2);
  const double longest_s =
      60.0 + 3.0 * laps.length() / limits.speed_mps + 4.0 * limits.speed_mps / limits.acceleration_mps2;
  Trajectory trajectory = drive(laps, nominal, from_seconds(longest_s), 0);
  if (ground) trajectory = trajectory.on(ground, course.start_height_m());
  std::vector<Eigen::Vector3d> path;
  for (const Motion& motion : trajectory.steps()) {
    const Eigen::Vector3d p(motion.x, motion.y, motion.slope.z);
    if (path.empty() || (p - path.back()).norm() >= kPathSpacing) path.push_back(p);
  }
  return path;
}

}  // namespace waymark::simulator
