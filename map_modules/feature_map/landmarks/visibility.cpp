// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/landmarks/visibility.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace waymark::feature_map {

namespace {

constexpr double kRounding = 1e-9;

/// atan2 to 2e-5 rad. M. Abramowitz, I. Stegun, Handbook of Mathematical Functions, 4.4.49.
double rough_atan2(double y, double x) {
  const double a = std::abs(x);
  const double b = std::abs(y);
  const double q = std::min(a, b) / std::max({a, b, 1e-300});
  const double s = q * q;
  double angle = q * (0.9998660 + s * (-0.3302995 + s * (0.1801410 + s * (-0.0851330 + s * 0.0208351))));
  if (b > a) angle = 0.5 * std::numbers::pi - angle;
  if (x < 0.0) angle = std::numbers::pi - angle;
  return y < 0.0 ? -angle : angle;
}

constexpr double kRoughAngle = 2e-5;

}  // namespace

ExpectedView::ExpectedView(const Pose& T_map_base, const ScanView& view, const ExistenceSettings& settings)
    : view_(view),
      settings_(settings),
      p_map_base_(T_map_base.p.head<2>()),
      cos_half_angle_(std::cos(settings.view_half_angle)),
      beams_per_radian_(1.0 / view.step) {
  const Eigen::Matrix3d R = T_map_base.q.toRotationMatrix();
  const Eigen::Matrix2d back = Eigen::Rotation2Dd(-view.yaw_base_sensor).toRotationMatrix();
  turn_ = back * R.topLeftCorner<2, 2>().transpose();
  p_offset_ = back * view.p_base_sensor;
  // A tilted sensor's plane is foreshortened: the smaller singular value of turn_ is R(2, 2), the other one 1.
  const double foreshortening = std::abs(R(2, 2));
  if (foreshortening > 1e-3) {
    center_ = p_map_base_ + turn_.inverse() * p_offset_;
    const double reach = settings.view_range / foreshortening;
    reach_square_ = reach * reach * (1.0 + kRounding);
  } else {
    center_ = p_map_base_;
    reach_square_ = std::numeric_limits<double>::infinity();
  }
}

double ExpectedView::as_scanned(double bearing) const {
  const double index = (bearing - view_.start) * beams_per_radian_;
  const double turn = std::copysign(2.0 * std::numbers::pi, beams_per_radian_);
  if (index < -0.5) return bearing + turn;
  return index > static_cast<double>(view_.ranges.size()) - 0.5 ? bearing - turn : bearing;
}

bool ExpectedView::is_surely_hidden(const Eigen::Vector2d& p_sensor, double distance) const {
  if (std::abs(view_.step) < 4.0 * kRoughAngle) return false;
  // Half a beam of rounding and less than half a beam of error: one of the two beams around the centre.
  const double bearing = as_scanned(rough_atan2(p_sensor.y(), p_sensor.x()));
  const double index = (bearing - view_.start) * beams_per_radian_ + 0.5;
  if (!(index >= 0.0) || index >= static_cast<double>(view_.ranges.size())) return true;
  return view_.ranges[static_cast<std::size_t>(index)] <= distance + settings_.free_margin;
}

bool ExpectedView::should_show(const Eigen::Vector2d& p_map, double radius) const {
  const Eigen::Vector2d p_sensor = turn_ * (p_map - p_map_base_) - p_offset_;
  const double square = p_sensor.squaredNorm();
  if (square > settings_.view_range * settings_.view_range || square <= radius * radius) return false;
  const double distance = std::sqrt(square);
  // The cosine decides, except at the very edge.
  const double inside = p_sensor.x() - cos_half_angle_ * distance;
  if (inside < -kRounding * distance) return false;
  if (!view_.ranges.empty() && is_surely_hidden(p_sensor, distance)) return false;
  const bool is_at_edge = inside <= kRounding * distance;
  if (view_.ranges.empty() && !is_at_edge) return true;

  const double bearing = std::atan2(p_sensor.y(), p_sensor.x());
  if (std::abs(bearing) > settings_.view_half_angle) return false;
  if (view_.ranges.empty()) return true;
  const double half_width = std::asin(std::min(1.0, radius / distance));
  const double last_index = static_cast<double>(view_.ranges.size()) - 1.0;
  const double scanned = as_scanned(bearing);
  const double a = (scanned - half_width - view_.start) / view_.step;
  const double b = (scanned + half_width - view_.start) / view_.step;
  const double low = std::floor(std::min(a, b));
  const double high = std::ceil(std::max(a, b));
  if (low < 0.0 || high > last_index) return false;
  for (auto i = static_cast<std::size_t>(low); i <= static_cast<std::size_t>(high); ++i) {
    if (view_.ranges[i] <= distance + settings_.free_margin) return false;  // occluded, hit, or blind
  }
  return true;
}

bool should_be_seen(const Eigen::Vector2d& p_map, double radius, const Pose& T_map_base, const ScanView& view,
                    const ExistenceSettings& settings) {
  return ExpectedView(T_map_base, view, settings).should_show(p_map, radius);
}

}  // namespace waymark::feature_map
