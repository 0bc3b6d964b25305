// SPDX-License-Identifier: Apache-2.0
#include "map_modules/octomap_grid/cloud_observation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "map_modules/octomap_grid/voxel_tile.hpp"
#include "waymark/base/error.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::octomap_grid {

namespace {

/// Of the points one in a voxel, and of those every n-th, so that at most `most` are left.
std::vector<Eigen::Vector3f> thinned(const std::vector<Eigen::Vector3f>& points, double resolution, std::size_t most) {
  std::vector<Eigen::Vector3f> thin;
  thin.reserve(points.size());
  std::unordered_set<std::uint64_t> seen;
  seen.reserve(points.size());
  constexpr std::uint64_t kDigits = 21;
  constexpr std::uint64_t kMask = (std::uint64_t{1} << kDigits) - 1;
  for (const Eigen::Vector3f& p : points) {
    std::uint64_t key = 0;
    for (int i = 0; i < 3; ++i) {
      const auto voxel = static_cast<std::int64_t>(std::floor(static_cast<double>(p(i)) / resolution));
      key = key << kDigits | (static_cast<std::uint64_t>(voxel) & kMask);
    }
    if (seen.insert(key).second) thin.push_back(p);
  }
  if (thin.size() <= most) return thin;
  std::vector<Eigen::Vector3f> few;
  few.reserve(most);
  for (std::size_t i = 0; i < most; ++i) few.push_back(thin[i * thin.size() / most]);
  return few;
}

/// The points at heights that are matched, by the attitude of the mixture: the same for all particles, since each point
/// lowers the evidence.
void keep_heights(std::vector<Eigen::Vector3f>& points, const Pose& T_map_base, const Heights& heights) {
  const Eigen::Matrix3d R_level_base =
      so3::from_rpy(0.0, 0.0, -T_map_base.yaw()).toRotationMatrix() * T_map_base.q.toRotationMatrix();
  const Eigen::RowVector3d up = R_level_base.row(2);
  std::erase_if(points, [&](const Eigen::Vector3f& p) { return !heights.hold(up * p.cast<double>()); });
}

}  // namespace

CloudObservation observe(const LaserScan& scan, const Pose& T_base_sensor, const MotionWindow& motion,
                         const OctomapGridSettings& settings) {
  CloudObservation observation(scan_matching::scan_points<3>(scan, T_base_sensor, motion, settings.scan));
  observation.matched = observation.hits;
  keep_heights(observation.matched, motion.T_map_base, settings.match_heights);
  return observation;
}

CloudObservation observe(const PointCloud& cloud, const Pose& T_base_sensor, const MotionWindow& motion,
                         const OctomapGridSettings& settings) {
  const std::size_t times = cloud.offsets_s.size();
  if (times != 0 && times != cloud.points_m.size()) {
    throw DataError(fmt::format("a cloud of {} points has times for {}", cloud.points_m.size(), times));
  }
  CloudObservation observation;
  observation.is_dense = true;
  observation.p_base_sensor = T_base_sensor.p;
  observation.reach = T_base_sensor.p.norm();
  observation.hits.reserve(cloud.points_m.size());
  Pose T_base_now;  // base at the stamp, base when the point was measured
  float offset = 0.0f;
  for (std::size_t i = 0; i < cloud.points_m.size(); ++i) {
    const Eigen::Vector3d p_sensor = cloud.points_m[i].cast<double>();
    const double range = p_sensor.norm();
    if (!(range >= settings.scan.range_min && range <= settings.scan.range_max)) continue;  // NaN, too
    if (times != 0 && cloud.offsets_s[i] != offset) {
      offset = cloud.offsets_s[i];
      T_base_now = motion.relative(static_cast<double>(offset));
    }
    const Eigen::Vector3d p_base = T_base_now * (T_base_sensor * p_sensor);
    if (!p_base.allFinite()) continue;  // a time that is not finite
    observation.reach = std::max(observation.reach, p_base.norm());
    observation.hits.emplace_back(p_base.cast<float>());
  }
  if (observation.hits.empty()) {
    throw DataError(
        fmt::format("none of the cloud's {} points lies between range_min_m and range_max_m", cloud.points_m.size()));
  }
  observation.matched =
      thinned(observation.hits, settings.resolution, static_cast<std::size_t>(settings.max_match_points));
  keep_heights(observation.matched, motion.T_map_base, settings.match_heights);
  return observation;
}

}  // namespace waymark::octomap_grid
