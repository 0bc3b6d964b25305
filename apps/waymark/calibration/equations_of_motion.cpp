// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "apps/waymark/calibration/equation_builder.hpp"

namespace waymark::calibration {

namespace {

constexpr double kGyroSeconds = 0.1;  // of one equation
constexpr double kMinDensity = 2e-4;  // of a standing robot: smaller ones leave no digits for the far end of the path
constexpr double kUsualGyroDensity = 8.73e-4;  // [rad/√s]
constexpr double kStandingSpeed = 0.01;        // [m/s]
constexpr double kStandingRate = 0.01;         // [rad/s]
constexpr double kUnknownMotion = 100.0;       // σ [m, rad] over a gap of the wheels

}  // namespace

/// Where the parameters and levels of one sensor of motion are among the unknowns (−1: it has none), and the values of
/// the parameters.
struct Equations::WheelModel {
  const WheelsGiven& given;
  int scale_column;
  int curvature_column;
  int length_column;  // of the track or wheelbase
  int yaw_scale_column;
  Density speed;
  Density lateral;
  Density yaw;
  Density turn;           // of the share that grows with the rate
  double scale;           // of the speed that the YAML gives
  double rotation_scale;  // of the yaw rate
  double curvature;
  double length_change;  // of the logarithm
  double yaw_scale_value;
};

Equations::WheelModel Equations::model_of(const Wheels& wheels, std::size_t index, const Builder& out) const {
  const WheelsGiven& given = wheels_given_[index];
  const auto value = [&](int column) { return column < 0 ? 0.0 : out.x(column); };
  WheelModel model{given,
                   column_of(wheels.sensor, "speed_scale"),
                   column_of(wheels.sensor, "curvature_per_m"),
                   std::max(column_of(wheels.sensor, "track_m"), column_of(wheels.sensor, "wheelbase_m")),
                   column_of(wheels.sensor, "yaw_scale"),
                   density_of(wheels.sensor, "speed_noise_m_per_sqrt_s"),
                   density_of(wheels.sensor, "lateral_noise_m_per_sqrt_s"),
                   density_of(wheels.sensor, "yaw_noise_rad_per_sqrt_s", 0),
                   density_of(wheels.sensor, "yaw_noise_rad_per_sqrt_s", 2),
                   1.0,
                   1.0,
                   0.0,
                   0.0,
                   1.0};
  model.scale = 1.0 + value(model.scale_column) / given.speed_scale;
  model.length_change = value(model.length_column);
  model.yaw_scale_value = given.yaw_scale + value(model.yaw_scale_column);
  const double yaw_scale = model.yaw_scale_value / given.yaw_scale * std::exp(-model.length_change);
  model.rotation_scale = (wheels.yaw_scales_with_speed ? model.scale : 1.0) * yaw_scale;
  model.curvature = given.curvature + value(model.curvature_column);
  return model;
}

/// The first sensor's stamps are the knots: over a gap nothing else ties two of them together.
void Equations::add_gap(std::size_t knot, Builder& out) const {
  const auto at = static_cast<Eigen::Index>(3 * knot);
  for (int i = 0; i < 3; ++i) {
    out.measurement();
    out.entry(at + i, -1.0);
    out.entry(at + 3 + i, 1.0);
    out.row(std::numeric_limits<double>::quiet_NaN(), out.x(at + 3 + i) - out.x(at + i), kUnknownMotion, {});
  }
}

void Equations::add_step(const Wheels& wheels, const WheelModel& model, std::size_t knot, const WheelStep& step,
                         Builder& out) const {
  const WheelsGiven& given = model.given;
  const double a = knots_[knot];
  const double b = knots_[knot + 1];
  const double span = b - a;
  const double middle = 0.5 * (a + b);
  const double per_span = 1.0 / std::sqrt(span);
  const auto at = static_cast<Eigen::Index>(3 * knot);
  const double turn = out.x(at + 5) - out.x(at + 2);
  const Eigen::Vector2d chord = out.x.segment<2>(at + 3) - out.x.segment<2>(at);
  const Eigen::Matrix2d R = rotation(out.x(at + 2) + 0.5 * turn).transpose();
  const Eigen::Vector2d v = R * chord * ((1.0 + turn * turn / 24.0) / span);
  const auto enter_speed = [&](int axis, double factor) {
    for (int i = 0; i < 2; ++i) {
      out.entry(at + i, -factor * R(axis, i) / span);
      out.entry(at + 3 + i, factor * R(axis, i) / span);
    }
    const double by_heading = 0.5 * factor * (axis == 0 ? v.y() : -v.x());
    out.entry(at + 2, by_heading);
    out.entry(at + 5, by_heading);
  };
  // Noise grows with the motion of the path: with what the wheels measure it would be smallest where they are wrong.
  const PoseAt moved = pose_at(out, middle, -1);
  const double smooth_speed = moved.velocity.norm();
  const double smooth_rate = std::abs(moved.rate);
  // Wheels that stand are right, whatever their noise is when they turn.
  const bool stands = smooth_speed < kStandingSpeed && smooth_rate < kStandingRate;
  const auto learns = [&](int level) { return stands ? -1 : level; };
  const auto sigma_of = [&](const Density& one) {
    return out.level(one.level) * (one.fixed + one.growing * smooth_speed);
  };

  // Two wheels of unequal size also move the robot forward while it turns: (b − a)/4 · (right − left), with the
  // wheels' scales a and b, whose difference is the curvature times the track.
  const double raw_speed = step.speed / given.speed_scale;
  const double raw_rate = step.rate ? *step.rate - given.curvature * raw_speed : 0.0;
  const double by_unequal = 0.25 * given.track * given.track * std::exp(model.length_change) * raw_rate;
  const double forward = v.x() - model.curvature * by_unequal;
  out.measurement();
  enter_speed(0, 1.0 / model.scale);
  out.entry(model.scale_column, -forward / (model.scale * model.scale * given.speed_scale));
  out.entry(model.curvature_column, -by_unequal / model.scale);
  out.entry(model.length_column, -model.curvature * by_unequal / model.scale);
  out.row(middle, forward / model.scale - step.speed, std::max(kMinDensity, sigma_of(model.speed)) * per_span,
          {{path_is_measured_ ? learns(model.speed.level) : -1, -1}, {2.0, 0.0}});

  out.measurement();
  enter_speed(1, 1.0 / model.scale);
  out.entry(model.scale_column, -v.y() / (model.scale * model.scale * given.speed_scale));
  out.row(middle, v.y() / model.scale - step.lateral, std::max(kMinDensity, sigma_of(model.lateral)) * per_span,
          {{path_is_measured_ ? learns(model.lateral.level) : -1, -1}, {2.0, 0.0}});

  if (!step.rate) return;
  // rate = rotation_scale · (what the wheels measure without the curvature) + curvature · speed without scale
  const double turned = (turn / span - model.curvature * raw_speed) / model.rotation_scale;
  out.measurement();
  out.entry(at + 2, -1.0 / (span * model.rotation_scale));
  out.entry(at + 5, 1.0 / (span * model.rotation_scale));
  out.entry(model.curvature_column, -raw_speed / model.rotation_scale);
  if (wheels.yaw_scales_with_speed) out.entry(model.scale_column, -turned / (model.scale * given.speed_scale));
  out.entry(model.length_column, turned);
  out.entry(model.yaw_scale_column, -turned / model.yaw_scale_value);
  const double steady = sigma_of(model.yaw);
  const double turning = out.level(model.turn.level) * model.turn.fixed * smooth_rate;
  const double all = std::max(kMinDensity, steady + turning);
  out.row(middle, turned - raw_rate, all * per_span,
          {{learns(model.yaw.level), learns(model.turn.level)}, {2.0 * steady / all, 2.0 * turning / all}});
}

void Equations::add_wheels(const Wheels& wheels, std::size_t index, Builder& out) const {
  const WheelModel model = model_of(wheels, index, out);
  for (std::size_t k = 0; k + 1 < knots_.size(); ++k) {
    const std::optional<double> speed = wheels.speed.mean(knots_[k], knots_[k + 1]);
    const std::optional<double> lateral = wheels.lateral.mean(knots_[k], knots_[k + 1]);
    if (speed && lateral) {
      add_step(wheels, model, k, {*speed, *lateral, wheels.rate.mean(knots_[k], knots_[k + 1])}, out);
    } else if (index == 0) {
      add_gap(k, out);
    }
  }
}

void Equations::add_gyro(const Gyro& gyro, std::size_t index, Builder& out) const {
  const int delay = column_of(gyro.sensor, "delay_s");
  const int level = gyro_levels_[index];
  const std::vector<double>& times = gyro.rate.times();
  std::size_t from = 0;
  for (std::size_t to = 1; to < times.size(); ++to) {
    const double span = times[to] - times[from];
    if (span < kGyroSeconds) continue;
    const double a = times[from];
    const double b = times[to];
    from = to;
    const std::optional<double> rate = gyro.rate.mean(a, b);
    if (!rate || !is_within(a) || !is_within(b)) continue;
    const PoseAt first = pose_at(out, a, delay);
    const PoseAt last = pose_at(out, b, delay);
    out.measurement();
    out.pose(first, Eigen::Vector3d(0.0, 0.0, -1.0 / span), delay);
    out.pose(last, Eigen::Vector3d(0.0, 0.0, 1.0 / span), delay);
    out.slow(biases_[index], a, 1.0);
    const double residual = (last.yaw - first.yaw) / span + out.slow_value(biases_[index], a) - *rate;
    out.row(a, residual, kUsualGyroDensity * out.level(level) / std::sqrt(span), {{level, -1}, {2.0, 0.0}});
  }
}

}  // namespace waymark::calibration
