// SPDX-License-Identifier: Apache-2.0
// Birth and death of landmarks: what counts as a miss, and what misses do.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sstream>

#include "map_modules/feature_map/landmarks/visibility.hpp"
#include "tests/unit/map_modules/feature_map/feature_map_bench.hpp"

namespace waymark::feature_map {
namespace {

using feature_map_test::detection_of;
using feature_map_test::kDegree;
using feature_map_test::observation_of;
using feature_map_test::scan_of;
using feature_map_test::settings_of;
using feature_map_test::step;
using feature_map_test::World;

const std::string kYaml =
    "extraction: { range_min_m: 0.5, range_max_m: 30, no_return_m: 80 },"
    "existence: { min_observations: 3, log_odds_hit: 0.7, log_odds_miss: -0.4, log_odds_max: 2.0, delete_below: -2.0, "
    "delete_provisional_below: -0.9,"
    " view_range_m: 20, view_half_angle_deg: 80, free_margin_m: 1, max_misses: 3 } }";
const World::Cylinder kPillar{{8.0, 1.0}, 0.2};
const Eigen::Matrix3d kPrior = Eigen::Vector3d(1e-3, 1e-3, 1e-5).asDiagonal();

FeatureObservation seen(const World& world) { return extract_cylinders(scan_of(world), {}, settings_of("{ " + kYaml)); }

/// A map at the origin that saw `world` `times` times.
ParticleFeatureMap map_of(const World& world, int times, const std::string& more = "") {
  ParticleFeatureMap map(std::make_shared<FeatureMapSettings>(settings_of("{ " + more + kYaml)));
  for (int i = 0; i < times; ++i) step(map, Eigen::Vector3d::Zero(), kPrior, Eigen::Matrix3d::Zero(), seen(world));
  return map;
}

Refinement look(ParticleFeatureMap& map, const World& world) {
  return step(map, Eigen::Vector3d::Zero(), kPrior, Eigen::Matrix3d::Zero(), seen(world));
}

std::vector<LandmarkView> shown(const ParticleFeatureMap& map) {
  MapDescription description;
  map.describe(description);
  return description.landmarks;
}

bool visible(const Eigen::Vector2d& p, const World& world, const Eigen::Vector3d& pose = Eigen::Vector3d::Zero()) {
  return should_be_seen(p, 0.2, Pose::planar(pose.x(), pose.y(), pose.z()), seen(world).view,
                        settings_of("{ " + kYaml).existence);
}

TEST(Visibility, ALandmarkInFreeViewShouldBeSeen) { EXPECT_TRUE(visible({8.0, 1.0}, World{})); }

TEST(Visibility, WhatIsThereWasSeen) { EXPECT_FALSE(visible({8.0, 1.0}, World{{kPillar}, {}})); }

TEST(Visibility, WhatStandsInFrontProtects) { EXPECT_FALSE(visible({8.0, 1.0}, World{{{{4.0, 0.5}, 0.3}}, {}})); }

TEST(Visibility, AWallRightBehindGivesNoFreeView) {
  EXPECT_FALSE(visible({8.0, 1.0}, World{{}, {{{8.5, -9.0}, {8.5, 9.0}}}}));
  EXPECT_TRUE(visible({8.0, 1.0}, World{{}, {{{9.5, -9.0}, {9.5, 9.0}}}}));
}

TEST(Visibility, APartlyHiddenLandmarkIsProtected) {
  EXPECT_FALSE(visible({8.0, 0.0}, World{{{{4.0, 0.17}, 0.1}}, {}}));
}

TEST(Visibility, BeyondTheViewRangeOrTheFieldOfViewNothingIsExpected) {
  EXPECT_FALSE(visible({20.5, 0.0}, World{}));
  EXPECT_TRUE(visible({19.5, 0.0}, World{}));
  EXPECT_FALSE(visible({8.0 * std::cos(82.0 * kDegree), 8.0 * std::sin(82.0 * kDegree)}, World{}));
  EXPECT_FALSE(visible({-8.0, 0.0}, World{}));
}

TEST(Visibility, CountsFromThePoseOfTheRobot) {
  EXPECT_TRUE(visible({-8.0, 0.0}, World{}, {0.0, 0.0, 180.0 * kDegree}));
  EXPECT_FALSE(visible({8.0, 0.0}, World{}, {-15.0, 0.0, 0.0}));
}

TEST(Visibility, AScannerMayCountItsBeamsFromAnyAngle) {
  auto existence = settings_of("{ " + kYaml).existence;
  existence.view_half_angle = 170.0 * kDegree;
  for (const double start : {-180.0, 0.0, 90.0}) {
    for (const double step : {0.5, -0.5}) {
      ScanView view;
      view.start = start * kDegree;
      view.step = step * kDegree;
      view.ranges.assign(720, std::numeric_limits<float>::infinity());
      // Behind one beam at 60° to the right something stands.
      const double index = std::remainder(-60.0 - start, 360.0) / step;
      view.ranges[static_cast<std::size_t>(index < 0.0 ? index + 720.0 : index)] = 3.0f;
      for (const double bearing : {-120.0, -45.0, 45.0, 120.0}) {
        const Eigen::Vector2d p(8.0 * std::cos(bearing * kDegree), 8.0 * std::sin(bearing * kDegree));
        EXPECT_TRUE(should_be_seen(p, 0.2, {}, view, existence)) << start << " " << step << " " << bearing;
      }
      EXPECT_FALSE(should_be_seen({4.0, -4.0 * std::sqrt(3.0)}, 0.2, {}, view, existence)) << start << " " << step;
    }
  }
}

TEST(Visibility, ABlindBeamExpectsNothing) {
  FeatureObservation observation = seen(World{});
  const auto existence = settings_of("{ " + kYaml).existence;
  ASSERT_TRUE(should_be_seen({8.0, 0.0}, 0.2, {}, observation.view, existence));
  observation.view.ranges[180] = 0.0f;
  EXPECT_FALSE(should_be_seen({8.0, 0.0}, 0.2, {}, observation.view, existence));
}

TEST(Visibility, WithoutAScanTheFieldOfViewDecides) {
  const ScanView view;
  const auto existence = settings_of("{ " + kYaml).existence;
  EXPECT_TRUE(should_be_seen({8.0, 0.0}, 0.2, {}, view, existence));
  EXPECT_FALSE(should_be_seen({-8.0, 0.0}, 0.2, {}, view, existence));
}

TEST(Existence, ALandmarkIsConfirmedAfterMinObservations) {
  auto map = map_of(World{{kPillar}, {}}, 2);
  ASSERT_EQ(shown(map).size(), 1u);
  EXPECT_FALSE(shown(map)[0].confirmed);
  look(map, World{{kPillar}, {}});
  ASSERT_EQ(shown(map).size(), 1u);
  EXPECT_TRUE(shown(map)[0].confirmed);
  EXPECT_EQ(shown(map)[0].sightings, 3);
}

// Log-odds 2.0 at most, − 0.4 a miss, gone below − 2.0: after the eleventh miss.
TEST(Existence, MissesRemoveALandmarkThatIsGone) {
  auto map = map_of(World{{kPillar}, {}}, 20);
  double existence = shown(map).at(0).existence;
  for (int miss = 0; miss < 9; ++miss) {
    look(map, World{});
    ASSERT_EQ(shown(map).size(), 1u) << miss;
    EXPECT_LT(shown(map)[0].existence, existence);
    existence = shown(map)[0].existence;
  }
  for (int miss = 0; miss < 3; ++miss) look(map, World{});
  EXPECT_TRUE(shown(map).empty());
}

TEST(Existence, AProvisionalLandmarkGoesSooner) {
  auto map = map_of(World{{kPillar}, {}}, 1);
  for (int miss = 0; miss < 3; ++miss) look(map, World{});
  EXPECT_TRUE(shown(map).empty());
}

TEST(Existence, OcclusionProtects) {
  auto map = map_of(World{{kPillar}, {}}, 5);
  const World truck{{}, {{{4.0, -3.0}, {4.0, 3.0}}}};
  const double existence = shown(map).at(0).existence;
  for (int i = 0; i < 100; ++i) look(map, truck);
  ASSERT_EQ(shown(map).size(), 1u);
  EXPECT_EQ(shown(map)[0].existence, existence);
}

TEST(Existence, WithoutNegativeInformationNothingIsRemoved) {
  auto map = map_of(World{{kPillar}, {}}, 5, "negative_information: false, ");
  for (int i = 0; i < 100; ++i) EXPECT_EQ(look(map, World{}).log_evidence, 0.0);
  EXPECT_EQ(shown(map).size(), 1u);
}

TEST(Existence, AMissOfAConfirmedLandmarkCostsEvidence) {
  auto map = map_of(World{{kPillar}, {}}, 5);
  const double existence = shown(map).at(0).existence;
  EXPECT_NEAR(look(map, World{}).log_evidence, std::log(1.0 - 0.9 * existence), 1e-9);
}

TEST(Existence, AMissOfAProvisionalLandmarkCostsNothing) {
  auto map = map_of(World{{kPillar}, {}}, 1);
  EXPECT_EQ(look(map, World{}).log_evidence, 0.0);
}

TEST(Existence, NoMoreMissesCountThanMaxMisses) {
  World many;
  for (int i = -3; i <= 3; ++i) many.cylinders.push_back({{9.0, 2.0 * i}, 0.2});
  auto map = map_of(many, 5);
  ASSERT_EQ(shown(map).size(), 7u);
  const double existence = shown(map)[0].existence;
  EXPECT_NEAR(look(map, World{}).log_evidence, 3.0 * std::log(1.0 - 0.9 * existence), 1e-9);
}

double figure(const ParticleFeatureMap& map, const std::string& name) {
  MapDescription description;
  map.describe(description);
  for (const MapFigure& one : description.figures) {
    if (one.name == name) return one.value;
  }
  ADD_FAILURE() << name;
  return 0.0;
}

TEST(Figures, CountBirthsAndDeathsOfConfirmedLandmarksOnly) {
  auto map = map_of(World{{kPillar}, {}}, 2);
  EXPECT_EQ(figure(map, "born"), 0.0);
  for (int i = 0; i < 5; ++i) look(map, World{{kPillar}, {}});
  EXPECT_EQ(figure(map, "born"), 1.0);
  for (int miss = 0; miss < 12; ++miss) look(map, World{});
  EXPECT_EQ(figure(map, "deleted"), 1.0);
  auto provisional = map_of(World{{kPillar}, {}}, 1);
  for (int miss = 0; miss < 3; ++miss) look(provisional, World{});
  EXPECT_EQ(figure(provisional, "deleted"), 0.0);
}

TEST(Figures, AmbiguousIsAMatchWithAnotherLandmarkNearlyAsLikely) {
  const auto share_of = [](double gap) {
    ParticleFeatureMap map(std::make_shared<FeatureMapSettings>(settings_of(
        "{ negative_information: false, association: { new_landmark_density_per_m2: 1.0e-4, min_separation_m: 0 } }")));
    const Eigen::Vector3d pose = Eigen::Vector3d::Zero();
    for (int i = 0; i < 4; ++i) {
      step(map, pose, kPrior, Eigen::Matrix3d::Zero(),
           observation_of({detection_of({8.0, 0.0}, pose, 0.3), detection_of({8.0, gap}, pose, 0.3)}));
    }
    return figure(map, "ambiguous_share");
  };
  EXPECT_EQ(share_of(5.0), 0.0);
  EXPECT_EQ(share_of(0.3), 1.0);
}

TEST(Figures, ComeBackFromAnArchive) {
  const auto map = map_of(World{{kPillar}, {}}, 5);
  std::stringstream stream;
  OutArchive out(stream);
  map.save(out);
  ParticleFeatureMap again = map_of(World{}, 0);
  InArchive in(stream);
  again.load(in);
  EXPECT_EQ(figure(again, "born"), 1.0);
}

}  // namespace
}  // namespace waymark::feature_map
