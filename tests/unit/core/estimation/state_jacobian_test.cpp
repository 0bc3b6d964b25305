// SPDX-License-Identifier: Apache-2.0
#include "estimation/state_jacobian.hpp"

#include <gtest/gtest.h>

namespace waymark {
namespace {

TEST(ObservesSpeed, IsTrueOfTheForwardVelocityAlone) {
  Linearization wheels;
  wheels.reset(1, 0);
  wheels.velocity()(0, 0) = 1.0;
  EXPECT_TRUE(estimation::observes_speed(wheels));

  Linearization does_not_slip;
  does_not_slip.reset(1, 0);
  does_not_slip.velocity()(0, 1) = 1.0;
  EXPECT_FALSE(estimation::observes_speed(does_not_slip));

  Linearization gyro;
  gyro.reset(1, 0);
  gyro.angular_rate()(0, 2) = 1.0;
  EXPECT_FALSE(estimation::observes_speed(gyro));
}

}  // namespace
}  // namespace waymark
