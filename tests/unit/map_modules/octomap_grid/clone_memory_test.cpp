// SPDX-License-Identifier: Apache-2.0
// needs plugins: occupancy_grid
// A copy of a particle's dense map shares everything with it: counted in bytes that the process asks for.
#include <gtest/gtest.h>

#include <memory>

#include "map_modules/occupancy_grid/particle_grid.hpp"
#include "map_modules/octomap_grid/particle_octomap.hpp"
#include "tests/unit/counted_memory.hpp"
#include "tests/unit/map_modules/occupancy_grid/simulated_room.hpp"
#include "tests/unit/map_modules/octomap_grid/simulated_hall.hpp"

namespace waymark::octomap_grid_test {
namespace {

void insert(ParticleMap& map, const Pose& T_map_base, const Observation& seen) {
  Refinement refinement;
  map.refine({T_map_base, Eigen::Matrix3d::Zero()}, T_map_base, seen, refinement);
  map.insert({T_map_base, Eigen::Matrix3d::Zero()}, seen, refinement.association.get());
}

double memory_of(const ParticleMap& map) {
  MapDescription description;
  map.describe(description);
  for (const MapFigure& figure : description.figures) {
    if (figure.name == "memory_bytes") return figure.value;
  }
  return 0.0;
}

/// What a copy adds, as a part of the map's own memory.
double share_of_a_clone(const ParticleMap& map) {
  const std::size_t before = counted::bytes;
  const std::unique_ptr<ParticleMap> copy = map.clone();
  const auto added = static_cast<double>(counted::bytes - before);
  EXPECT_GT(added, 0.0);
  return added / memory_of(map);
}

TEST(CloneMemory, ACopyOfAFlatGridAddsLessThanAHundredthOfARoom) {
  occupancy_grid::ParticleGrid map(std::make_shared<occupancy_grid::GridModel>(occupancy_grid_test::settings()));
  const Pose at = Pose::planar(0.0, 0.0, 0.4);
  insert(map, at, occupancy_grid_test::observed(occupancy_grid_test::room(), {0.0, 0.0, 0.4}, 0.02));
  EXPECT_GT(memory_of(map), 10e3);
  EXPECT_LT(share_of_a_clone(map), 0.01);
}

TEST(CloneMemory, ACopyOfAnOctreeAddsLessThanAHundredthOfAHall) {
  ParticleOctomap map(std::make_shared<OctomapModel>(settings()));
  const Pose at = Pose::planar(0.0, 0.0, 0.4);
  insert(map, at, observed(Hall(), at, tilted(), settings(), 0.02, 1));
  EXPECT_GT(memory_of(map), 10e3);
  EXPECT_LT(share_of_a_clone(map), 0.01);
}

/// The counter sees what a write makes anew.
TEST(CloneMemory, AWriteIntoACopyIsCounted) {
  occupancy_grid::ParticleGrid map(std::make_shared<occupancy_grid::GridModel>(occupancy_grid_test::settings()));
  const auto seen = occupancy_grid_test::observed(occupancy_grid_test::room(), {0.0, 0.0, 0.4}, 0.02);
  insert(map, Pose::planar(0.0, 0.0, 0.4), seen);
  const std::unique_ptr<ParticleMap> copy = map.clone();
  const std::size_t before = counted::bytes;
  insert(*copy, Pose::planar(0.3, 0.1, 0.4), seen);
  EXPECT_GT(static_cast<double>(counted::bytes - before), 0.1 * memory_of(map));
}

}  // namespace
}  // namespace waymark::octomap_grid_test
