// SPDX-License-Identifier: Apache-2.0
// needs plugins: occupancy_grid
// A scanner that turns measures one beam after the other, while the robot drives and turns.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "map_modules/octomap_grid/cloud_observation.hpp"
#include "tests/unit/map_modules/occupancy_grid/simulated_room.hpp"
#include "tests/unit/map_modules/octomap_grid/simulated_hall.hpp"

namespace waymark::octomap_grid_test {
namespace {

class Sweep : public ::testing::Test {
 protected:
  Sweep() {
    scan_.step_rad = std::numbers::pi / 180.0;
    scan_.start_rad = -0.5 * std::numbers::pi;
    scan_.beam_interval_s = 5e-4;
    for (int k = 0; k < 180; ++k) {
      const Pose T_map_sensor = T_map_base_ * motion_.relative(k * scan_.beam_interval_s) * T_base_sensor_;
      const double bearing = T_map_sensor.yaw() + scan_.start_rad + k * scan_.step_rad;
      const double range =
          occupancy_grid_test::range_to(occupancy_grid_test::room(), T_map_sensor.p.head<2>(), bearing);
      scan_.ranges_m.push_back(range < 80.0 ? static_cast<float>(range) : 81.0f);
    }
  }

  /// The farthest of the points from a wall, if the base is where it was at the stamp [m].
  double farthest_from_a_wall(const std::vector<Eigen::Vector2f>& points) const {
    double farthest = 0.0;
    for (const Eigen::Vector2f& point : points) {
      const Eigen::Vector3d on_base(point.x(), point.y(), 0.0);
      const Eigen::Vector2d p = (T_map_base_ * on_base).head<2>();
      double nearest = 1e9;
      for (const occupancy_grid_test::Wall& w : occupancy_grid_test::room()) {
        const Eigen::Vector2d from(w[0], w[1]);
        const Eigen::Vector2d way = Eigen::Vector2d(w[2], w[3]) - from;
        const double along = std::clamp((p - from).dot(way) / way.squaredNorm(), 0.0, 1.0);
        nearest = std::min(nearest, (p - from - along * way).norm());
      }
      farthest = std::max(farthest, nearest);
    }
    return farthest;
  }

  const MotionWindow motion_{{1.2, 0.1, 0.0}, {0.0, 0.0, 1.5}};
  const Pose T_map_base_ = Pose::planar(-1.0, 0.3, 0.6);
  const Pose T_base_sensor_ = Pose::planar(0.4, -0.1, 0.2);
  LaserScan scan_;
};

TEST_F(Sweep, AFlatGridSeesTheWallsInTheirPlaces) {
  const auto scan = occupancy_grid_test::settings().scan;
  const auto seen = occupancy_grid::observe(scan_, T_base_sensor_, motion_, scan);
  EXPECT_GT(seen.hits.size(), 150u);
  EXPECT_LT(farthest_from_a_wall(seen.hits), 1e-4);
  // As if the robot had stood, they are not.
  EXPECT_GT(farthest_from_a_wall(occupancy_grid::observe(scan_, T_base_sensor_, {}, scan).hits), 0.2);
}

TEST_F(Sweep, AnOctreeSeesWhatAFlatGridSees) {
  const auto flat = occupancy_grid::observe(scan_, T_base_sensor_, motion_, occupancy_grid_test::settings().scan);
  const CloudObservation seen = observe(scan_, T_base_sensor_, motion_, settings());
  ASSERT_EQ(seen.hits.size(), flat.hits.size());
  for (std::size_t i = 0; i < flat.hits.size(); ++i) EXPECT_EQ(seen.hits[i].head<2>(), flat.hits[i]);
}

}  // namespace
}  // namespace waymark::octomap_grid_test
