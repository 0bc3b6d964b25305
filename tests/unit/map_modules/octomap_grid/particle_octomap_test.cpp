// SPDX-License-Identifier: Apache-2.0
// needs plugins: occupancy_grid
#include "map_modules/octomap_grid/particle_octomap.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>

#include "map_modules/occupancy_grid/particle_grid.hpp"
#include "plugins/shared/map_formats/map_manifest.hpp"
#include "temporary_folder.hpp"
#include "tests/unit/map_modules/occupancy_grid/simulated_room.hpp"
#include "tests/unit/map_modules/octomap_grid/simulated_hall.hpp"
#include "waymark/base/error.hpp"

namespace waymark::octomap_grid_test {
namespace {

const Eigen::Matrix3d kPrior = Eigen::Vector3d(0.04, 0.04, 0.01).asDiagonal();

/// Where the refined Gaussian has its mean, relative to the prior's.
Eigen::Vector3d mean_of(const Refinement& r, const Eigen::Matrix3d& P) {
  return P * (Eigen::Matrix3d::Identity() + r.information * P).inverse() * r.gradient;
}

template <class Map>
void insert(Map& map, const Pose& T_map_base, const Observation& seen) {
  Refinement refinement;
  map.refine({T_map_base, Eigen::Matrix3d::Zero()}, T_map_base, seen, refinement);
  map.insert({T_map_base, Eigen::Matrix3d::Zero()}, seen, refinement.association.get());
}

TEST(ParticleOctomap, MatchesAPlanarScanAsTheFlatGridDoes) {
  occupancy_grid::ParticleGrid flat(std::make_shared<occupancy_grid::GridModel>(occupancy_grid_test::settings()));
  ParticleOctomap octomap(std::make_shared<OctomapModel>(settings("{ resolution_m: 0.05 }")));
  const OctomapGridSettings s = settings("{ resolution_m: 0.05 }");
  const auto scan = [](const Eigen::Vector3d& pose, std::uint32_t seed) {
    return occupancy_grid_test::scan_of(occupancy_grid_test::room(), pose, 0.01, seed);
  };
  const Pose none;
  std::uint32_t seed = 0;
  for (int round = 0; round < 3; ++round) {
    for (const Eigen::Vector3d& p : {Eigen::Vector3d(0, 0, 0), {0, 0, 3.1}, {4, 0, 1.5}, {-2, -1, -0.5}}) {
      const LaserScan seen = scan(p, ++seed);
      insert(flat, Pose::planar(p.x(), p.y(), p.z()),
             occupancy_grid::observe(seen, none, {}, occupancy_grid_test::settings().scan));
      insert(octomap, Pose::planar(p.x(), p.y(), p.z()), observe(seen, none, {}, s));
    }
  }
  const Eigen::Vector3d truth(0.1, -0.2, 0.05);
  for (const Eigen::Vector3d& offset :
       {Eigen::Vector3d(0.0, 0.0, 0.0), Eigen::Vector3d(0.12, -0.1, 0.05), Eigen::Vector3d(-0.1, 0.12, -0.06)}) {
    const Eigen::Vector3d at = truth - offset;
    const Pose prior = Pose::planar(at.x(), at.y(), at.z());
    const LaserScan seen = scan(truth, 99);
    Refinement of_flat;
    Refinement of_octomap;
    flat.refine({prior, kPrior}, prior, occupancy_grid::observe(seen, none, {}, occupancy_grid_test::settings().scan),
                of_flat);
    octomap.refine({prior, kPrior}, prior, observe(seen, none, {}, s), of_octomap);
    EXPECT_LT((mean_of(of_octomap, kPrior) - offset).head<2>().norm(), 0.025);
    EXPECT_LT((mean_of(of_octomap, kPrior) - mean_of(of_flat, kPrior)).norm(), 1e-3);
    EXPECT_NEAR(of_octomap.log_evidence, of_flat.log_evidence, 0.01 * std::abs(of_flat.log_evidence));
    EXPECT_LT((of_octomap.information - of_flat.information).norm(), 0.02 * of_flat.information.norm());
  }
}

class InTheHall : public ::testing::Test {
 protected:
  std::shared_ptr<const OctomapModel> model_ =
      std::make_shared<OctomapModel>(settings("{ slice_m: [0.2, 1.0], match: { height_m: [0, 2.4] } }"));

  CloudObservation seen_from(const Pose& T_map_base, std::uint32_t seed) const {
    return observed(Hall(), T_map_base, tilted(), model_->settings, 0.01, seed);
  }
  ParticleOctomap mapped() const {
    ParticleOctomap map(model_);
    std::uint32_t seed = 0;
    for (int round = 0; round < 2; ++round) {
      for (int i = 0; i < 12; ++i) {
        const Pose at = Pose::planar(0.3 * i - 1.0, 0.1 * i, 0.55 * i);
        insert(map, at, seen_from(at, ++seed));
      }
    }
    return map;
  }
  /// Matches a cloud that is seen from the truth, with a prior whose mean is off.
  Refinement match(const ParticleOctomap& map, const Eigen::Vector3d& truth, const Eigen::Vector3d& offset) const {
    const Eigen::Vector3d at = truth - offset;
    const Pose prior = Pose::planar(at.x(), at.y(), at.z());
    Refinement refinement;
    map.refine({prior, kPrior}, prior, seen_from(Pose::planar(truth.x(), truth.y(), truth.z()), 77), refinement);
    return refinement;
  }
};

TEST_F(InTheHall, AScannerThatLooksDownFindsItsPlace) {
  const ParticleOctomap map = mapped();
  for (const Eigen::Vector3d& offset :
       {Eigen::Vector3d(0.0, 0.0, 0.0), Eigen::Vector3d(0.15, -0.1, 0.04), Eigen::Vector3d(-0.12, 0.14, -0.05)}) {
    for (const Eigen::Vector3d& truth : {Eigen::Vector3d(0.5, 0.2, 0.3), {1.2, -0.3, 2.0}, {-0.4, 0.9, -1.4}}) {
      const Refinement refinement = match(map, truth, offset);
      const Eigen::Vector3d found = mean_of(refinement, kPrior);
      EXPECT_LT((found - offset).head<2>().norm(), 0.05) << found.transpose() << " for " << offset.transpose();
      EXPECT_LT(std::abs((found - offset).z()), 0.01);
    }
  }
}

class OnPlanes : public InTheHall {
 protected:
  OnPlanes() { model_ = std::make_shared<OctomapModel>(settings("{ match: { kind: planes, height_m: [0, 2.4] } }")); }
};

TEST_F(OnPlanes, AMatchIsNotLimitedByTheVoxels) {
  const ParticleOctomap map = mapped();
  for (const Eigen::Vector3d& offset : {Eigen::Vector3d(0.0, 0.0, 0.0), Eigen::Vector3d(0.15, -0.1, 0.04)}) {
    for (const Eigen::Vector3d& truth : {Eigen::Vector3d(0.5, 0.2, 0.3), {1.2, -0.3, 2.0}, {-0.4, 0.9, -1.4}}) {
      const Refinement refinement = match(map, truth, offset);
      const Eigen::Vector3d found = mean_of(refinement, kPrior);
      EXPECT_LT((found - offset).head<2>().norm(), 0.01) << found.transpose() << " for " << offset.transpose();
      EXPECT_LT(std::abs((found - offset).z()), 0.003);
      EXPECT_FALSE(refinement.spatial);
    }
  }
}

/// Where the robot moves in space, height, roll and pitch stay as they are.
TEST_F(OnPlanes, AMatchMovesXYAndYawAlone) {
  const ParticleOctomap map = mapped();
  const Pose truth = Pose::planar(0.5, 0.2, 0.3);
  PoseGaussian prior{Pose::planar(0.45, 0.25, 0.28), kPrior};
  prior.P_spatial = SpatialMatrix(0.01 * SpatialMatrix::Identity());
  Refinement refinement;
  map.refine(prior, prior.T_map_base, seen_from(truth, 77), refinement);
  EXPECT_LT((mean_of(refinement, kPrior) - Eigen::Vector3d(0.05, -0.05, 0.02)).norm(), 0.015);
}

/// Roll, pitch and height of the robot count: a robot on a ramp sees the same walls in their places.
TEST_F(InTheHall, ARobotOnARampFindsItsPlace) {
  const ParticleOctomap map = mapped();
  const Pose truth{so3::from_rpy(0.05, -0.12, 0.4), {0.6, 0.1, 0.25}};
  const Eigen::Vector3d offset(0.1, -0.08, 0.03);
  const Pose prior{so3::from_rpy(0.05, -0.12, 0.4 - offset.z()),
                   truth.p - Eigen::Vector3d(offset.x(), offset.y(), 0.0)};
  const CloudObservation seen = seen_from(truth, 5);
  Refinement refinement;
  map.refine({prior, kPrior}, prior, seen, refinement);
  EXPECT_LT((mean_of(refinement, kPrior) - offset).head<2>().norm(), 0.05);
  // Held for level, the same cloud fits worse.
  Refinement level;
  const Pose flat = Pose::planar(prior.p.x(), prior.p.y(), prior.yaw());
  map.refine({flat, kPrior}, flat, seen, level);
  EXPECT_LT(level.log_evidence, refinement.log_evidence);
}

TEST_F(InTheHall, ALoadedMapLiesWhereItsManifestSays) {
  Pose placed = Pose::planar(30.0, -7.0, 2.1);
  placed.p.z() = 0.4;
  const test::TemporaryFolder folder;
  const std::vector<MapFile> files = mapped().files(placed);
  std::ofstream(folder / "hall.ot", std::ios::binary) << files.at(1).content;
  map_formats::MapManifest manifest{folder / "maps.yaml", Datum{48.0, 11.0, 500.0}, {}};
  manifest.layers.push_back({"hall", "octree", folder / "hall.ot", files.at(1).T_enu_file});
  std::ofstream(folder / "maps.yaml") << map_formats::manifest_text(manifest, folder.path());
  const std::string yaml =
      "{ slice_m: [0.6, 1.4], match: { height_m: [0, 2.4] }, mode: continue, load: " + (folder / "maps.yaml").string() +
      " }";
  const auto model = std::make_shared<OctomapModel>(settings(yaml.c_str()));
  ASSERT_TRUE(model->settings.load.frame && model->settings.load.frame->datum);
  ParticleOctomap map(model);

  const Pose truth = Pose::planar(0.5, 0.2, 0.3);
  const Eigen::Vector3d offset(0.15, -0.1, 0.04);  // in the frame of the manifest, from the prior to the truth
  Pose prior = placed * truth;
  prior = {so3::from_rpy(0.0, 0.0, prior.yaw() - offset.z()), prior.p - Eigen::Vector3d(offset.x(), offset.y(), 0.0)};
  Refinement refinement;
  const CloudObservation seen = seen_from(truth, 77);
  map.refine({prior, kPrior}, prior, seen, refinement);
  const Eigen::Vector3d found = mean_of(refinement, kPrior);
  EXPECT_LT((found - offset).head<2>().norm(), 0.05) << found.transpose();
  EXPECT_LT(std::abs((found - offset).z()), 0.01);

  // What is seen again goes where it already is, and the map is written where it lies.
  const auto occupied = [](const ParticleOctomap& one) {
    MapDescription description;
    one.describe(description);
    return description.figures.front().value;
  };
  const double before = occupied(map);
  for (int i = 0; i < 5; ++i) insert(map, placed * truth, seen);
  EXPECT_LT(occupied(map), 1.05 * before);
  const Pose again = map.files(Pose::planar(1.0, 0.0, 0.0)).at(1).T_enu_file;
  EXPECT_LT((again.p - placed.p - Eigen::Vector3d(1.0, 0.0, 0.0)).norm(), 1e-9);
  const std::optional<GridView> grid = map.grid();
  ASSERT_TRUE(grid);
  EXPECT_NEAR(grid->T_map_grid.yaw(), 2.1, 1e-9);
}

TEST_F(InTheHall, ASliceShowsWhatStandsInIt) {
  const ParticleOctomap map = mapped();
  const std::optional<GridView> grid = map.grid();
  ASSERT_TRUE(grid);
  EXPECT_DOUBLE_EQ(grid->resolution_m, 0.1);
  const auto at = [&](const Eigen::Vector3d& p_hall) {
    const Eigen::Vector3d p = Hall::turn() * p_hall - grid->T_map_grid.p;
    const int x = static_cast<int>(std::floor(p.x() / 0.1));
    const int y = static_cast<int>(std::floor(p.y() / 0.1));
    return grid->cells[static_cast<std::size_t>(y * grid->width + x)];
  };
  EXPECT_GT(at({2.05, 1.5, 0.0}), 50);  // the box that ends at 1.3 m
  EXPECT_LT(at({0.0, 0.0, 0.0}), 50);   // the floor lies below the slice
  EXPECT_EQ(at({2.5, 1.6, 0.0}), GridView::kUnknown);
}

TEST_F(InTheHall, ComesBackFromACheckpointAsAFamily) {
  const ParticleOctomap parent = mapped();
  const std::unique_ptr<ParticleMap> child = parent.clone();
  const Pose elsewhere = Pose::planar(2.0, -1.5, 1.0);
  insert(*child, elsewhere, seen_from(elsewhere, 3));
  const auto bytes = [](std::span<const ParticleMap* const> maps) {
    std::ostringstream stream;
    OutArchive out(stream);
    for (const ParticleMap* map : maps) map->save(out);
    return stream.str();
  };
  const std::array<const ParticleMap*, 1> alone{&parent};
  const std::array<const ParticleMap*, 1> other{child.get()};
  const std::array<const ParticleMap*, 2> both{&parent, child.get()};
  const std::string family = bytes(both);
  EXPECT_LT(family.size(), bytes(alone).size() + bytes(other).size());

  std::istringstream stream(family);
  InArchive in(stream);
  ParticleOctomap parent_again(model_);
  ParticleOctomap child_again(model_);
  parent_again.load(in);
  child_again.load(in);
  const std::array<const ParticleMap*, 2> again{&parent_again, &child_again};
  EXPECT_EQ(bytes(again), family);
  const std::array<const VoxelMap*, 2> before{&parent.voxels(), &static_cast<const ParticleOctomap&>(*child).voxels()};
  const std::array<const VoxelMap*, 2> after{&parent_again.voxels(), &child_again.voxels()};
  EXPECT_EQ(VoxelMap::bytes_of(after), VoxelMap::bytes_of(before));

  std::istringstream wrong_stream(family);
  InArchive wrong_in(wrong_stream);
  ParticleOctomap coarse(std::make_shared<OctomapModel>(settings("{ resolution_m: 0.2 }")));
  EXPECT_THROW(coarse.load(wrong_in), DataError);
}

/// Maps of the first version held nodes of OctoMap.
TEST_F(InTheHall, RefusesACheckpointOfTheFirstVersion) {
  std::stringstream stream;
  OutArchive(stream).section("octomap_grid", 1);
  InArchive in(stream);
  ParticleOctomap map(model_);
  try {
    map.load(in);
    FAIL() << "was read";
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("maps are not read any more"));
  }
}

/// What a copy writes, and that it goes again, is nothing to the map that it was copied from.
TEST_F(InTheHall, ACopysWritesAreItsOwn) {
  const ParticleOctomap parent = mapped();
  const auto bytes = [](const ParticleMap& map) {
    std::ostringstream stream;
    OutArchive out(stream);
    map.save(out);
    return stream.str();
  };
  const std::string before = bytes(parent);
  for (std::uint32_t seed = 0; seed < 3; ++seed) {
    const std::unique_ptr<ParticleMap> child = parent.clone();
    const std::unique_ptr<ParticleMap> grandchild = child->clone();
    const Pose elsewhere = Pose::planar(1.0 + seed, -1.5, 1.0);
    insert(*child, elsewhere, seen_from(elsewhere, 30 + seed));
    EXPECT_NE(bytes(*child), before);
    EXPECT_EQ(bytes(*grandchild), before);
  }
  EXPECT_EQ(bytes(parent), before);
}

TEST_F(InTheHall, TellsWhatItsCloudsLack) {
  const auto message = [&](const PointCloud& cloud) -> std::string {
    try {
      observe(cloud, Pose{}, {}, model_->settings);
    } catch (const DataError& error) {
      return error.what();
    }
    return "none";
  };
  PointCloud cloud;
  EXPECT_EQ(message(cloud), "none of the cloud's 0 points lies between range_min_m and range_max_m");
  const float nan = std::numeric_limits<float>::quiet_NaN();
  cloud.points_m = {{nan, 1, 1}, {0.01f, 0, 0}, {500, 0, 0}};
  EXPECT_EQ(message(cloud), "none of the cloud's 3 points lies between range_min_m and range_max_m");
  cloud.points_m.emplace_back(1, 2, 0);
  EXPECT_EQ(message(cloud), "none");
  cloud.offsets_s = {0.0f};
  EXPECT_EQ(message(cloud), "a cloud of 4 points has times for 1");
}

/// Every point is put where it was seen from the base at the stamp.
TEST_F(InTheHall, CloudsAreDeskewed) {
  PointCloud cloud;
  cloud.points_m = {{2, 0, 0}, {2, 0, 0}};
  cloud.offsets_s = {0.0f, 0.1f};
  MotionWindow motion;
  motion.v_base = {1.0, 0.0, 0.0};
  motion.w_base = {0.0, 0.0, 0.5};
  const CloudObservation seen = observe(cloud, Pose{}, motion, model_->settings);
  ASSERT_EQ(seen.hits.size(), 2U);
  EXPECT_TRUE(seen.hits[0].isApprox(Eigen::Vector3f(2, 0, 0)));
  const Eigen::Vector3d expected = motion.relative(0.1) * Eigen::Vector3d(2, 0, 0);
  EXPECT_TRUE(seen.hits[1].isApprox(expected.cast<float>(), 1e-5f));
  EXPECT_GT(seen.hits[1].y(), 0.09f);
}

TEST_F(InTheHall, MatchesAtMostSoManyPoints) {
  const OctomapGridSettings few = settings("{ match: { max_points: 100 } }");
  const CloudObservation seen = observed(Hall(), Pose{}, tilted(), few);
  EXPECT_EQ(seen.matched.size(), 100U);
  EXPECT_EQ(seen.hits.size(), 16U * 360U);
}

TEST(OctomapGridSettings, RefusesWhatMakesNoSense) {
  EXPECT_THROW(settings("{ slice_m: [1, 0] }"), ConfigError);
  EXPECT_THROW(settings("{ match: { height_m: [1, 1] } }"), ConfigError);
  EXPECT_THROW(settings("{ resolution_m: 0.01, range_max_m: 40 }"), ConfigError);
  EXPECT_THROW(settings("{ mode: localize }"), ConfigError);
  EXPECT_THROW(settings("{ load: map.bt }"), ConfigError);
}

}  // namespace
}  // namespace waymark::octomap_grid_test
