// SPDX-License-Identifier: Apache-2.0
#include "visibility.hpp"

#include <algorithm>
#include <cmath>

namespace waymark {

bool should_be_seen(const Eigen::Vector2d& p_map, double radius, const Pose& T_map_base, const ScanView& view,
                    const ExistenceSettings& settings) {
  const Eigen::Vector2d p_base =
      (T_map_base.inverse() * Eigen::Vector3d(p_map.x(), p_map.y(), T_map_base.p.z())).head<2>();
  const Eigen::Vector2d p_sensor = Eigen::Rotation2Dd(-view.yaw_base_sensor) * (p_base - view.p_base_sensor);
  const double distance = p_sensor.norm();
  if (distance > settings.view_range || distance <= radius) return false;
  const double bearing = std::atan2(p_sensor.y(), p_sensor.x());
  if (std::abs(bearing) > settings.view_half_angle) return false;
  if (view.ranges.empty()) return true;

  const double half_width = std::asin(std::min(1.0, radius / distance));
  const double last_index = static_cast<double>(view.ranges.size()) - 1.0;
  const double a = (bearing - half_width - view.start) / view.step;
  const double b = (bearing + half_width - view.start) / view.step;
  const double low = std::floor(std::min(a, b));
  const double high = std::ceil(std::max(a, b));
  if (low < 0.0 || high > last_index) return false;
  for (auto i = static_cast<std::size_t>(low); i <= static_cast<std::size_t>(high); ++i) {
    if (view.ranges[i] <= distance + settings.free_margin) return false;  // occluded, hit, or blind
  }
  return true;
}

}  // namespace waymark
