// SPDX-License-Identifier: Apache-2.0
// needs plugins: feature_map, odometry
// The contract's threads, short enough for the thread sanitizer.
#include <gtest/gtest.h>

#include "our_plugins.hpp"
#include "waymark/testing/map_module_contract.hpp"
#include "waymark/testing/sensor_contract.hpp"

namespace waymark::contract_test {
namespace {

TEST(OurPluginsInThreads, OdometryUpdatesAreReadByManyThreads) {
  const auto sensor = make<Sensor>(
      "odometry", "{ model: differential, track_m: 0.5, speed_scale_sigma: 0.02, curvature_sigma_per_m: 0.01 }");
  EXPECT_EQ(testing::to_text(testing::check_sensor(*sensor, wheel_speeds(4), StateLayout::Motion::planar)), "");
}

TEST(OurPluginsInThreads, ClonesOfAFeatureMapAreWrittenByManyThreads) {
  const auto module = make<MapModule>("feature_map", feature_map_yaml("radius, signature"));
  EXPECT_EQ(testing::to_text(testing::check_map_module(*module, mapping_steps(6))), "");
}

}  // namespace
}  // namespace waymark::contract_test
