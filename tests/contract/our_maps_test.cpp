// SPDX-License-Identifier: Apache-2.0
// needs plugins: feature_map, occupancy_grid, octomap_grid
#include <gtest/gtest.h>

#include <limits>

#include "our_plugins.hpp"
#include "waymark/testing/map_module_contract.hpp"

namespace waymark::contract_test {
namespace {

using testing::check_map_module;
using testing::MappingStep;
using testing::to_text;

class OurFeatureMap : public ::testing::TestWithParam<const char*> {};

TEST_P(OurFeatureMap, KeepsTheContractOnScans) {
  const auto module = make<MapModule>("feature_map", feature_map_yaml(GetParam()));
  EXPECT_EQ(to_text(check_map_module(*module, mapping_steps(30))), "");
}

TEST_P(OurFeatureMap, KeepsTheContractOnLandmarkObservations) {
  std::vector<MappingStep> steps;
  for (const Measurement& m : stream_of<LandmarkObservations>(20, [](LandmarkObservations&seen, double t) {
         seen.landmarks.push_back(
             {.range_m = 5.0 - 0.5 * t, .bearing_rad = 0.3 + 0.1 * t, .radius_m = 0.2, .identity = 4});
         if (t > 0.5) seen.landmarks.push_back({.range_m = 8.0, .bearing_rad = -1.0 + 0.01 * t});
       })) {
    steps.push_back({.trigger = m,
                     .T_map_base = Pose::planar(
                         0.5 * to_seconds(m.stamp.time_since_epoch() - Duration{100'000'000'000}), 0.0, 0.0)});
  }
  const auto module = make<MapModule>("feature_map", feature_map_yaml(GetParam()));
  EXPECT_EQ(to_text(check_map_module(*module, steps)), "");
}

INSTANTIATE_TEST_SUITE_P(Attributes, OurFeatureMap, ::testing::Values("", "radius", "signature", "radius, signature"));

// The contract means little if nothing is found in the scans.
TEST(OurFeatureMap, TheScansOfTheseTestsHoldLandmarks) {
  const auto module = make<MapModule>("feature_map", feature_map_yaml("radius"));
  const auto map = module->create_map();
  for (const MappingStep& step : mapping_steps(30)) {
    const auto observation = module->extract(step.trigger, {}, {});
    Refinement refinement;
    map->refine({step.T_map_base, 1e-4 * Eigen::Matrix3d::Identity()}, step.T_map_base, *observation, refinement);
    map->insert({step.T_map_base, Eigen::Matrix3d::Zero()}, *observation, refinement.association.get());
  }
  MapDescription description;
  map->describe(description);
  EXPECT_GE(description.landmarks.size(), 8u);
}

class OurOccupancyGrid : public ::testing::TestWithParam<const char*> {};

TEST_P(OurOccupancyGrid, KeepsTheContractOnScans) {
  const auto module = make<MapModule>("occupancy_grid", GetParam());
  EXPECT_EQ(to_text(check_map_module(*module, mapping_steps(20))), "");
}

INSTANTIATE_TEST_SUITE_P(
    Settings, OurOccupancyGrid,
    ::testing::Values("{ inputs: [lidar], update_distance_m: 0, range_max_m: 19 }",
                      "{ inputs: [lidar], update_distance_m: 0, range_max_m: 19, no_return_m: 20.5,"
                      "  no_return_clears_m: 10, resolution_m: 0.1 }"));

TEST(OurOccupancyGrid, TheScansOfTheseTestsMakeAMap) {
  const auto module = make<MapModule>("occupancy_grid", "{ inputs: [lidar], update_distance_m: 0, range_max_m: 19 }");
  const auto map = module->create_map();
  int informed = 0;
  for (const MappingStep& step : mapping_steps(20)) {
    const auto observation = module->extract(step.trigger, {}, {});
    Refinement refinement;
    map->refine({step.T_map_base, 1e-4 * Eigen::Matrix3d::Identity()}, step.T_map_base, *observation, refinement);
    map->insert({step.T_map_base, Eigen::Matrix3d::Zero()}, *observation, refinement.association.get());
    informed += refinement.information.trace() > 0.0;
  }
  EXPECT_GE(informed, 15);
  const std::optional<GridView> grid = map->grid();
  ASSERT_TRUE(grid);
  EXPECT_GT(grid->width, 100);
}

class OurOctomapGrid : public ::testing::TestWithParam<const char*> {};

TEST_P(OurOctomapGrid, KeepsTheContractOnScans) {
  const auto module = make<MapModule>("octomap_grid", GetParam());
  EXPECT_EQ(to_text(check_map_module(*module, mapping_steps(12))), "");
}

/// The same scans as clouds: four of them above one another.
TEST_P(OurOctomapGrid, KeepsTheContractOnClouds) {
  std::vector<MappingStep> steps = mapping_steps(10);
  for (MappingStep& step : steps) {
    const auto& scan = step.trigger.as<LaserScan>();
    auto cloud = std::make_shared<PointCloud>();
    for (std::size_t k = 0; k < scan.ranges_m.size(); ++k) {
      const auto bearing = static_cast<float>(scan.start_rad + static_cast<double>(k) * scan.step_rad);
      const float r = scan.ranges_m[k];
      if (r > 19.0f) continue;
      for (const float up : {-0.1f, 0.0f, 0.1f, 0.2f}) {
        cloud->points_m.emplace_back(r * std::cos(bearing), r * std::sin(bearing), r * up);
        cloud->offsets_s.push_back(1e-4f * static_cast<float>(k));
      }
    }
    step.trigger.payload = std::move(cloud);
    step.T_map_base.q = so3::from_rpy(0.02, -0.01, step.T_map_base.yaw());
    step.motion.v_base.x() = 0.5;
  }
  const auto module = make<MapModule>("octomap_grid", GetParam());
  EXPECT_EQ(to_text(check_map_module(*module, steps)), "");
}

INSTANTIATE_TEST_SUITE_P(
    Settings, OurOctomapGrid,
    ::testing::Values("{ inputs: [lidar], update_distance_m: 0, range_max_m: 19 }",
                      "{ inputs: [lidar], update_distance_m: 0, range_max_m: 19, no_return_m: 20.5,"
                      "  no_return_clears_m: 10, resolution_m: 0.2, match: { max_points: 200 } }"));

}  // namespace
}  // namespace waymark::contract_test
