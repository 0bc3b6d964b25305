// SPDX-License-Identifier: Apache-2.0
#include "waymark/config/nearest_name.hpp"

#include <gtest/gtest.h>

namespace waymark {
namespace {

TEST(NearestName, FindsTheOneWithTheFewestEdits) {
  EXPECT_EQ(nearest_name("simga_m", {"sigma_rad", "sigma_m", "offset_sigma_m"}), "sigma_m");
  EXPECT_EQ(nearest_name("odmetry_sensr", {"odometry_sensors", "odometry_sensor"}), "odometry_sensor");
}

TEST(NearestName, TakesAsManyEditsAsATypingErrorMayHave) {
  EXPECT_EQ(nearest_name("gps", {"gps12"}), "gps12");
  EXPECT_EQ(nearest_name("gps", {"gps123"}), "");
  EXPECT_EQ(nearest_name("gps12", {"gps"}), "gps");
  EXPECT_EQ(nearest_name("odometer_", {"odo_eter"}), "odo_eter");
  EXPECT_EQ(nearest_name("odometers", {"odometers_12"}), "odometers_12");
  EXPECT_EQ(nearest_name("odometers", {"odometers_123"}), "");
}

TEST(NearestName, FindsTheSameWordsInAnotherOrder) {
  EXPECT_EQ(nearest_name("vertical_sigma_m", {"sigma_m", "offset_sigma_m", "sigma_vertical_m"}), "sigma_vertical_m");
}

TEST(NearestName, FindsNothingThatSharesNothing) { EXPECT_EQ(nearest_name("a", {"b", "xyz"}), ""); }

}  // namespace
}  // namespace waymark
