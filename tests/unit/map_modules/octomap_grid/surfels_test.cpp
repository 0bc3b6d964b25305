// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <random>
#include <sstream>

#include "map_modules/octomap_grid/octomap_grid_settings.hpp"
#include "map_modules/octomap_grid/surfels/surfel_map.hpp"
#include "map_modules/octomap_grid/surfels/surfel_matcher.hpp"
#include "waymark/base/error.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::octomap_grid {
namespace {

constexpr double kCell = 0.4;

/// Points on the floor, the ceiling, the walls and a slanted plate of a room of 8 m × 6 m × 3 m, in the map.
std::vector<Eigen::Vector3d> room(std::uint32_t seed, int points) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::normal_distribution<double> noise(0.0, 0.01);
  const Eigen::Vector3d size(8.0, 6.0, 3.0);
  std::vector<Eigen::Vector3d> out;
  out.reserve(static_cast<std::size_t>(points));
  for (int i = 0; i < points; ++i) {
    Eigen::Vector3d p(uniform(random), uniform(random), uniform(random));
    p = p.cwiseProduct(size);
    const int side = i % 7;
    if (side < 6) p(side / 2) = side % 2 == 0 ? 0.0 : size(side / 2);
    if (side == 6) p = {2.0 + p.x() / 8.0, 1.0 + p.y() / 6.0, 0.8 + 0.5 * p.x() / 8.0};
    p += Eigen::Vector3d(noise(random), noise(random), noise(random));
    out.push_back(p - Eigen::Vector3d(4.0, 3.0, 1.0));
  }
  return out;
}

std::vector<Eigen::Vector3f> seen_from(const Pose& T_map_base, std::uint32_t seed, int points) {
  std::vector<Eigen::Vector3f> out;
  out.reserve(static_cast<std::size_t>(points));
  for (const Eigen::Vector3d& p : room(seed, points)) out.emplace_back((T_map_base.inverse() * p).cast<float>());
  return out;
}

scan_matching::MatchSettings match_settings(const std::string& yaml = "{}") {
  return scan_matching::MatchSettings::read(Config::parse(yaml), scan_matching::MatchDefaults::planes());
}

class InARoom : public ::testing::Test {
 protected:
  InARoom() { map_.add(seen_from({}, 1, 20'000), {}, kCell, addition_); }

  SpatialMatch match(const Pose& truth, const Pose& guess, const SpatialMatrix& P, const std::string& yaml = "{}") {
    return matcher_.match(map_, kCell, seen_from(truth, 2, 1000), 6.0, {guess, P, SpatialVector::Zero()},
                          match_settings(yaml));
  }
  static SpatialVector difference(const Pose& a, const Pose& b) {
    SpatialVector d;
    d << a.p - b.p, so3::log(a.q * b.q.conjugate());
    return d;
  }
  static SpatialMatrix wide() {
    SpatialVector sigma;
    sigma << 1.0, 1.0, 1.0, 0.5, 0.5, 0.5;
    return sigma.cwiseAbs2().asDiagonal();
  }

  SurfelAddition addition_;
  SurfelMap map_;
  SurfelMatcher matcher_;
};

TEST(Surfel, FitsThePlaneOfItsPoints) {
  Surfel surfel;
  const Eigen::Vector3f normal = Eigen::Vector3f(1.0f, 2.0f, 2.0f) / 3.0f;
  const Eigen::Vector3f a = normal.unitOrthogonal();
  const Eigen::Vector3f b = normal.cross(a);
  for (int i = -2; i <= 2; ++i) {
    for (int j = -2; j <= 2; ++j)
      surfel.add(0.05f * normal + 0.08f * static_cast<float>(i) * a + 0.08f * static_cast<float>(j) * b);
  }
  surfel.fit(0.4f);
  ASSERT_TRUE(surfel.is_plane());
  EXPECT_NEAR(std::abs(surfel.normal.dot(normal)), 1.0f, 1e-5f);
  EXPECT_NEAR(std::abs(surfel.normal.dot(surfel.middle)), 0.05f, 1e-5f);
}

TEST(Surfel, ALineAndACloudAreNoPlanes) {
  Surfel line;
  for (int i = 0; i < 20; ++i) line.add(Eigen::Vector3f(0.01f * static_cast<float>(i), 0.0f, 0.0f));
  line.fit(0.4f);
  EXPECT_FALSE(line.is_plane());
  Surfel cloud;
  for (int i = 0; i < 27; ++i) {
    cloud.add(0.1f * Eigen::Vector3f(static_cast<float>(i % 3 - 1), static_cast<float>(i / 3 % 3 - 1),
                                     static_cast<float>(i / 9 - 1)));
  }
  cloud.fit(0.4f);
  EXPECT_FALSE(cloud.is_plane());
}

TEST_F(InARoom, FindsAllSixOfThePose) {
  const Pose truth{so3::from_rpy(0.03, -0.05, 0.2), {0.5, -0.4, 0.2}};
  for (const Pose& guess : {truth, Pose{so3::from_rpy(0.0, 0.0, 0.1), {0.3, -0.3, 0.1}},
                            Pose{so3::from_rpy(-0.1, 0.1, 0.4), {0.8, -0.1, 0.0}}}) {
    const SpatialMatch found = match(truth, guess, wide());
    ASSERT_FALSE(found.failed);
    const SpatialVector error = found.d - difference(truth, guess);
    EXPECT_LT(error.head<3>().norm(), 0.015);
    EXPECT_LT(error.tail<3>().norm(), 0.006);
    EXPECT_GT(found.score, 0.7);
  }
}

TEST_F(InARoom, TheClaimedCovarianceIsThatOfTheErrors) {
  const Pose truth{so3::from_rpy(0.02, 0.01, -0.3), {-0.4, 0.3, 0.1}};
  double squared = 0.0;
  constexpr int kScans = 30;
  for (std::uint32_t seed = 10; seed < 10 + kScans; ++seed) {
    const SpatialMatch found = matcher_.match(map_, kCell, seen_from(truth, seed, 1000), 6.0,
                                              {truth, wide(), SpatialVector::Zero()}, match_settings());
    squared += found.d.dot(found.information * found.d) / kScans;
  }
  // Six degrees of freedom; the map's own error is the same in all.
  EXPECT_LT(squared, 12.0);
  EXPECT_GT(squared, 0.2);
}

TEST_F(InARoom, AnotherHeadingIsFoundByTheSearchOnly) {
  const Pose truth{so3::from_rpy(0.0, 0.0, 0.85), {0.3, 0.2, 0.0}};
  SpatialVector sigma;
  sigma << 0.5, 0.5, 0.1, 0.05, 0.05, 1.0;
  const SpatialMatrix P = sigma.cwiseAbs2().asDiagonal();
  const SpatialMatch found = match(truth, Pose{}, P, "{ coarse_angle_deg: 60 }");
  ASSERT_FALSE(found.failed);
  EXPECT_LT((found.d - difference(truth, Pose{})).norm(), 0.03);
}

TEST_F(InARoom, AFloorAloneLeavesThePlaneFree) {
  SurfelMap floor;
  std::vector<Eigen::Vector3f> points;
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform(-4.0f, 4.0f);
  points.reserve(8000);
  for (int i = 0; i < 8000; ++i) points.emplace_back(uniform(random), uniform(random), -1.0f);
  floor.add(points, {}, kCell, addition_);
  std::vector<Eigen::Vector3f> some(points.begin(), points.begin() + 800);
  const SpatialMatch found = matcher_.match(
      floor, kCell, some, 6.0, {Pose{{1, 0, 0, 0}, {0.0, 0.0, 0.1}}, wide(), SpatialVector::Zero()}, match_settings());
  ASSERT_FALSE(found.failed);
  EXPECT_NEAR(found.d[2], -0.1, 1e-3);
  const double up = found.information(2, 2);
  EXPECT_GT(up, 100.0);
  for (const int planar : {0, 1, 5}) EXPECT_LT(found.information(planar, planar), 1e-4 * up) << planar;
}

TEST_F(InARoom, AFarWallCountsThoughItsSmallestCellsHoldTooFewPoints) {
  // A floor near the scanner, and a wall with one point in a smallest cell: it alone says where along x.
  const auto scene = [](std::uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> shift(0.0f, 0.4f);
    std::vector<Eigen::Vector3f> points;
    for (int i = 0; i < 30; ++i) {
      for (int j = 0; j < 30; ++j)
        points.emplace_back(0.1f * static_cast<float>(i) + 0.1f * shift(random), 0.1f * static_cast<float>(j), -1.0f);
    }
    for (int i = 0; i < 12; ++i) {
      for (int j = 0; j < 8; ++j)
        points.emplace_back(7.1f, 0.4f * static_cast<float>(i) + shift(random),
                            0.4f * static_cast<float>(j) - shift(random));
    }
    return points;
  };
  SurfelMap map;
  map.add(scene(1), {}, kCell, addition_);
  SpatialVector sigma;
  sigma << 0.3, 0.01, 0.1, 0.01, 0.01, 0.01;
  const SpatialMatch found = matcher_.match(
      map, kCell, scene(2), 9.0,
      {Pose{{1, 0, 0, 0}, {0.15, 0.0, 0.0}}, sigma.cwiseAbs2().asDiagonal(), SpatialVector::Zero()}, match_settings());
  ASSERT_FALSE(found.failed);
  EXPECT_NEAR(found.d[0], -0.15, 0.02);
  EXPECT_GT(found.information(0, 0), 1.0 / (0.05 * 0.05));
}

TEST_F(InARoom, APriorThatIsCertainIsNotMoved) {
  const Pose guess{so3::from_rpy(0.0, 0.0, 0.02), {0.05, 0.0, 0.0}};
  EXPECT_TRUE(match(Pose{}, guess, SpatialMatrix::Zero()).d.isZero(1e-12));
}

TEST_F(InARoom, ACopySharesTilesUntilItWrites) {
  SurfelMap copy = map_;
  EXPECT_TRUE(copy.level(0).shares_root_with(map_.level(0)));
  const auto planes = [](const SurfelMap& map) {
    std::vector<MapFigure> figures;
    map.describe(figures);
    return figures.front().value;
  };
  const double before = planes(map_);
  copy.add(seen_from({}, 3, 2000), Pose{{1, 0, 0, 0}, {20.0, 0.0, 0.0}}, kCell, addition_);
  EXPECT_EQ(planes(map_), before);
  EXPECT_GT(planes(copy), before);
}

TEST_F(InARoom, CellsThatHoldEnoughStayAsTheyAre) {
  const SurfelMap before = map_;
  for (std::uint32_t seed = 4; seed < 60; ++seed) map_.add(seen_from({}, seed, 20'000), {}, kCell, addition_);
  const SurfelMap full = map_;
  map_.add(seen_from({}, 99, 20'000), {}, kCell, addition_);
  EXPECT_FALSE(map_.level(2).shares_root_with(before.level(2)));
  EXPECT_TRUE(map_.level(2).shares_root_with(full.level(2)));
}

TEST_F(InARoom, ACheckpointHasTheSameMap) {
  std::stringstream stream;
  OutArchive out(stream);
  out(map_);
  InArchive in(stream);
  SurfelMap read;
  in(read);
  const Pose truth{so3::from_rpy(0.03, -0.05, 0.2), {0.5, -0.4, 0.2}};
  const SpatialMatch of_read = matcher_.match(read, kCell, seen_from(truth, 2, 1000), 6.0,
                                              {Pose{}, wide(), SpatialVector::Zero()}, match_settings());
  EXPECT_EQ(of_read.d, match(truth, Pose{}, wide()).d);
}

TEST(SurfelMap, APointBeyondAllPlacesIsRefused) {
  SurfelMap map;
  SurfelAddition addition;
  const std::vector<Eigen::Vector3f> points{{1e12f, 0.0f, 0.0f}};
  EXPECT_THROW(map.add(points, {}, kCell, addition), Error);
}

}  // namespace
}  // namespace waymark::octomap_grid
