// SPDX-License-Identifier: Apache-2.0
// Which scans a particle's grid writes.
#include "map_modules/occupancy_grid/particle_grid.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <numbers>

#include "tests/unit/map_modules/occupancy_grid/simulated_room.hpp"

namespace waymark::occupancy_grid_test {
namespace {

class WrittenScans : public ::testing::Test {
 protected:
  /// Matches a scan that was taken at this pose, and writes it there. True if it is written, the map being another one
  /// then.
  bool sees(const Eigen::Vector3d& xyyaw, bool measures_motion) {
    ScanObservation scan = observed(room(), xyyaw);
    scan.measures_motion = measures_motion;
    const Pose pose = Pose::planar(xyyaw.x(), xyyaw.y(), xyyaw.z());
    const PoseGaussian prior{pose, 1e-4 * Eigen::Matrix3d::Identity()};
    grid_.refine(prior, pose, scan, refinement_);
    const TileTree before = grid_.tiles();
    grid_.insert(prior, scan, refinement_.association.get());
    const bool is_changed = !before.shares_root_with(grid_.tiles());
    EXPECT_TRUE(refinement_.writes || !is_changed);
    return refinement_.writes;
  }

  ParticleGrid grid_{std::make_shared<GridModel>(settings("{ update_distance_m: 0.2, update_angle_deg: 10 }"))};
  Refinement refinement_;
};

TEST_F(WrittenScans, AreThoseAfterSomeMotionWhereNothingElseMeasuresIt) {
  constexpr double kDegree = std::numbers::pi / 180.0;
  EXPECT_TRUE(sees({0.0, 0.0, 0.0}, true));
  EXPECT_FALSE(sees({0.0, 0.0, 0.0}, true)) << "a robot that stands";
  EXPECT_FALSE(sees({0.15, 0.0, 0.0}, true));
  EXPECT_TRUE(sees({0.25, 0.0, 0.0}, true));
  EXPECT_FALSE(sees({0.25, 0.0, 9.0 * kDegree}, true));
  EXPECT_TRUE(sees({0.25, 0.0, -11.0 * kDegree}, true));
  EXPECT_FALSE(sees({0.25, 0.0, -11.0 * kDegree}, true)) << "from the last one that was written";
}

TEST_F(WrittenScans, AreAllThatWereTakenWhereTheMotionIsMeasured) {
  EXPECT_TRUE(sees({0.0, 0.0, 0.0}, false));
  EXPECT_TRUE(sees({0.0, 0.0, 0.0}, false));
}

TEST_F(WrittenScans, AreAllWhereAMapIsDrawnAgain) {
  ScanObservation scan = observed(room(), {0.0, 0.0, 0.0});
  scan.measures_motion = true;
  const PoseGaussian pose{Pose{}, Eigen::Matrix3d::Zero()};
  grid_.insert(pose, scan, nullptr);
  const TileTree once = grid_.tiles();
  grid_.insert(pose, scan, nullptr);
  EXPECT_FALSE(once.shares_root_with(grid_.tiles()));
}

}  // namespace
}  // namespace waymark::occupancy_grid_test
