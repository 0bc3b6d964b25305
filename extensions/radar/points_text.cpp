// SPDX-License-Identifier: Apache-2.0
#include "points_text.hpp"

#include <cmath>

namespace waymark::radar {

std::optional<PointsText::Point> PointsText::next_point() {
  if (!table_.next()) return std::nullopt;
  Point point{table_.time(0), {}};
  const Eigen::Vector3d p(table_.number(1), table_.number(2), table_.number(3));
  const double radial = table_.number(4);
  const double range = p.norm();
  if (range == 0.0) return point;
  RadarTargets::One& one = point.target.emplace();
  one.range_m = range;
  one.azimuth_rad = std::atan2(p.y(), p.x());
  one.elevation_rad = std::atan2(p.z(), p.head<2>().norm());
  one.radial_mps = radial;
  return point;
}

std::optional<Scan> PointsText::read() {
  if (!ahead_) ahead_ = next_point();
  if (!ahead_) return std::nullopt;
  Scan scan;
  scan.stamp = ahead_->stamp;
  while (ahead_ && ahead_->stamp == scan.stamp) {
    if (ahead_->target) scan.targets.push_back(*ahead_->target);
    ahead_ = next_point();
  }
  return scan;
}

}  // namespace waymark::radar
