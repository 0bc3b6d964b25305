// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <numbers>

#include "imu_updates.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::imu {
namespace {

/// Tilt that is left after so many steps of Gauss-Newton from a wrong attitude, if the robot stands level [rad].
double left_after(int steps, double roll, double pitch) {
  const TiltUpdate update(Eigen::Vector3d::UnitZ(), 1e-4);
  NavState nav;
  nav.T_map_base.q = so3::from_rpy(roll, pitch, 0.4);
  Linearization out;
  for (int i = 0; i < steps; ++i) {
    update.linearize({.nav = nav, .block = {}}, out);
    const Eigen::Vector2d step = out.attitude().leftCols<2>().fullPivLu().solve(out.residual.head<2>());
    nav.T_map_base.q = so3::exp({step.x(), step.y(), 0.0}) * nav.T_map_base.q;
  }
  const Eigen::Vector3d up = nav.T_map_base.q * Eigen::Vector3d::UnitZ();
  return std::atan2(up.head<2>().norm(), up.z());
}

TEST(TiltUpdate, LeadsBackToLevelFromAnyTilt) {
  for (const double tilt : {0.1, 0.5, 0.75, 0.85, 1.5, 2.5, 3.1, std::numbers::pi}) {
    EXPECT_LT(left_after(6, tilt, 0.0), 1e-6) << tilt;
    EXPECT_LT(left_after(6, 0.0, -tilt), 1e-6) << tilt;
    EXPECT_LT(left_after(6, 0.7 * tilt, 0.3 * tilt), 1e-6) << tilt;
  }
}

/// Its x and y components alone are as small there as for a level one.
TEST(TiltUpdate, TheResidualOfARobotOnItsHeadIsHalfATurn) {
  const TiltUpdate update(Eigen::Vector3d::UnitZ(), 1e-4);
  NavState nav;
  nav.T_map_base.q = so3::from_rpy(std::numbers::pi, 0.0, 0.0);
  Linearization out;
  update.linearize({.nav = nav, .block = {}}, out);
  EXPECT_NEAR(out.residual.norm(), std::numbers::pi, 1e-3);
}

}  // namespace
}  // namespace waymark::imu
