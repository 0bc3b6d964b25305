// SPDX-License-Identifier: Apache-2.0
#include "map_modules/shared/scan_matching/scan_matcher.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <string>

#include "tests/unit/map_modules/occupancy_grid/simulated_room.hpp"
#include "waymark/base/error.hpp"
#include "waymark/math/gaussian.hpp"
#include "waymark/math/random.hpp"

namespace waymark::occupancy_grid_test {
namespace {

constexpr double kResolution = 0.05;

Eigen::Matrix3d covariance(double position, double yaw) {
  return Eigen::Vector3d(position * position, position * position, yaw * yaw).asDiagonal();
}

struct Bench {
  Bench(std::vector<Wall> w, const std::vector<Eigen::Vector3d>& poses, const char* use = "{}")
      : walls(std::move(w)), yaml(use), tiles(mapped(walls, poses, yaml)) {}

  Match match(const Eigen::Vector3d& truth, const MatchPrior& prior, double sigma_m = 0.0, std::uint32_t seed = 1) {
    return find(truth, prior, sigma_m, seed).match;
  }
  FoundMatch find(const Eigen::Vector3d& truth, const MatchPrior& prior, double sigma_m, std::uint32_t seed = 1) {
    const ScanObservation scan = observed(walls, truth, sigma_m, seed, yaml);
    window.open(tiles, prior.mean.head<2>(), scan.reach + matcher.margin(prior), kResolution);
    return matcher.match(window, scan.hits, prior);
  }

  std::vector<Wall> walls;
  const char* yaml;
  TileTree tiles;
  TileWindow window;
  ScanMatcher matcher{settings().match, kResolution};
};

TEST(ScanMatching, ASumThatCannotReachTheBestOneEndsEarly) {
  Bench bench(room(), {{0, 0, 0}, {0, 0, 3.1}});
  const ScanObservation scan = observed(bench.walls, {0.1, -0.1, 0.1}, 0.0, 1, bench.yaml);
  bench.window.open(bench.tiles, {0.0, 0.0}, scan.reach + 3.0, kResolution);
  const scan_matching::LikelihoodTable table(0.12, kResolution);
  const auto sum = [&](double x, double least) {
    return scan_matching::sum_likelihood(bench.window, table, scan.hits, {x, -0.1, 0.1}, kResolution, least);
  };
  const double best = sum(0.1, 0.0);
  const double far = sum(1.0, 0.0);
  ASSERT_GT(best, 1.5 * far);
  EXPECT_EQ(sum(0.1, best), best) << "what reaches it is whole";
  EXPECT_EQ(sum(1.0, far), far);
  EXPECT_LT(sum(1.0, best), best);
  EXPECT_LT(sum(1.0, best), far) << "the rest was not added";
}

TEST(ScanMatching, FindsAKnownOffsetInARoom) {
  Bench bench(room(), {{0, 0, 0}, {0, 0, 3.1}, {4, 0, 1.5}, {-2, -1, -0.5}});
  const Eigen::Vector3d truth(0.1, -0.2, 0.05);
  for (const Eigen::Vector3d& offset :
       {Eigen::Vector3d(0.0, 0.0, 0.0), Eigen::Vector3d(0.12, -0.1, 0.05), Eigen::Vector3d(-0.1, 0.12, -0.06)}) {
    const Match match = bench.match(truth, {truth - offset, covariance(0.3, 0.2), Eigen::Vector3d::Zero()}, 0.01);
    ASSERT_FALSE(match.failed);
    EXPECT_LT((match.d - offset).head<2>().norm(), 0.5 * kResolution) << offset.transpose();
    EXPECT_LT(std::abs((match.d - offset).z()), 0.004) << offset.transpose();
    EXPECT_FALSE(match.searched);
  }
}

TEST(ScanMatching, SearchesCoarselyWhereTheStartLeadsNowhere) {
  Bench bench(room(), {{0, 0, 0}, {0, 0, 3.1}, {4, 0, 1.5}, {-2, -1, -0.5}});
  const Eigen::Vector3d truth(0.1, -0.2, 0.05);
  const Eigen::Vector3d offset(0.25, -0.24, 0.1);
  Match match = bench.match(truth, {truth - 2.0 * offset, covariance(1.0, 0.5), offset}, 0.01);
  ASSERT_FALSE(match.failed);
  EXPECT_LT((match.d - 2.0 * offset).norm(), 0.03);
  // Where nothing fits the prior stands, and that is said.
  match = bench.match(truth, {truth + Eigen::Vector3d(3.0, 2.0, 1.2), covariance(0.05, 0.02), Eigen::Vector3d::Zero()});
  EXPECT_TRUE(match.searched);
  EXPECT_TRUE(match.misfits);
  EXPECT_TRUE(match.failed);
  EXPECT_TRUE(match.d.isZero());
  EXPECT_TRUE(match.information.isZero());
  EXPECT_TRUE(match.gradient.isZero());
  EXPECT_LT(match.log_evidence, 0.0);
}

/// Walls, and a crowd about the robot: a wall of half a circle, 0.6 m away.
std::vector<Wall> crowded(std::vector<Wall> walls, const Eigen::Vector3d& robot) {
  constexpr int kPeople = 12;
  const auto place = [&](int k) -> Eigen::Vector2d {
    const double angle = robot.z() + std::numbers::pi * k / kPeople;
    return robot.head<2>() + 0.6 * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  };
  for (int k = 0; k < kPeople; ++k) walls.push_back({place(k).x(), place(k).y(), place(k + 1).x(), place(k + 1).y()});
  return walls;
}

TEST(ScanMatching, WhatHidesTheMapDoesNotContradictIt) {
  const Eigen::Vector3d truth(0.1, -0.2, 0.05);
  const MatchPrior prior{truth, covariance(0.05, 0.02), Eigen::Vector3d::Zero()};
  const std::vector<Eigen::Vector3d> poses{{0, 0, 0}, {0, 0, 3.1}, {4, 0, 1.5}, {-2, -1, -0.5}};
  Bench bench(room(), poses);
  bench.walls = crowded(room(), truth);
  Match match = bench.match(truth, prior);
  EXPECT_LT(match.score, settings().match.search_score);
  EXPECT_TRUE(match.searched);
  EXPECT_FALSE(match.misfits);
  // A robot that looks through what the map shows contradicts it.
  Bench gone(crowded(room(), truth), {truth, truth, truth});
  gone.walls = room();
  match = gone.match(truth, prior);
  EXPECT_LT(match.score, settings().match.search_score);
  EXPECT_TRUE(match.misfits);
}

/// Pillars of 0.3 m and nothing else: no long wall leads a descent to the right heading.
std::vector<Wall> pillars() {
  constexpr double kSide = 0.3;
  std::vector<Wall> walls;
  Random random({5, 0, 0, 0});
  for (int i = 0; i < 40; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / 40.0;
    const double distance = 2.0 + 4.0 * random.uniform();
    const double x = distance * std::cos(angle);
    const double y = distance * std::sin(angle);
    walls.insert(walls.end(), {{x, y, x + kSide, y},
                               {x + kSide, y, x + kSide, y + kSide},
                               {x + kSide, y + kSide, x, y + kSide},
                               {x, y + kSide, x, y}});
  }
  return walls;
}

// Wheels whose readings come late miss a turn by more than any noise says.
TEST(ScanMatching, TurnsFartherWhereNothingNearTheStartFits) {
  Bench bench(pillars(), {{0, 0, 0}, {0, 0, 3.1}, {0.1, 0, 1.5}, {-0.1, -0.1, -0.5}});
  const Eigen::Vector3d truth(0.1, -0.2, 0.05);
  for (const Eigen::Vector3d& offset : {Eigen::Vector3d(0.15, -0.1, 0.36), Eigen::Vector3d(-0.2, 0.05, -0.36)}) {
    const Match match = bench.match(truth, {truth - offset, covariance(0.1, 0.07), Eigen::Vector3d::Zero()}, 0.01);
    ASSERT_FALSE(match.failed) << offset.transpose();
    EXPECT_TRUE(match.searched) << offset.transpose();
    EXPECT_LT((match.d - offset).norm(), 0.03) << offset.transpose();
  }
}

// By the prior's σ alone (90 nats) the particle would lose against one that fits nothing.
TEST(ScanMatching, WhatIsFoundFarOutsideThePriorIsASlip) {
  Bench bench(pillars(), {{0, 0, 0}, {0, 0, 3.1}, {0.1, 0, 1.5}, {-0.1, -0.1, -0.5}});
  const Eigen::Vector3d truth(0.1, -0.2, 0.05);
  const Eigen::Vector3d offset(0.2, -0.2, 0.3);
  const MatchPrior narrow{truth - offset, covariance(0.025, 0.04), Eigen::Vector3d::Zero()};
  MatchSettings certain = settings().match;  // pillars give few points: a scan of walls says more
  certain.evidence_tempering *= 3.0;
  bench.matcher = ScanMatcher(certain, kResolution);
  const Match slipped = bench.match(truth, narrow, 0.01);
  ASSERT_FALSE(slipped.failed);
  EXPECT_GT(slipped.slip.minCoeff(), 0.0);
  EXPECT_LT((slipped.d - offset).norm(), 0.03);
  const MatchPrior wide{truth - offset, covariance(0.2, 0.2), Eigen::Vector3d::Zero()};
  const Match expected = bench.match(truth, wide, 0.01);
  ASSERT_FALSE(expected.failed);
  EXPECT_TRUE(expected.slip.isZero()) << "a turn that the noise allows is none";
  EXPECT_GT(slipped.log_evidence, expected.log_evidence - 8.0) << "by the probability of a slip, not by the prior's σ";
  EXPECT_LT(slipped.log_evidence, expected.log_evidence);
}

// The host may refuse a match that the prior does not expect.
TEST(ScanMatching, BesideWhatIsNotExpectedIsWhatThereIsWithoutIt) {
  Bench bench(pillars(), {{0, 0, 0}, {0, 0, 3.1}, {0.1, 0, 1.5}, {-0.1, -0.1, -0.5}});
  const Eigen::Vector3d truth(0.1, -0.2, 0.05);
  const MatchPrior right{truth, covariance(0.025, 0.04), Eigen::Vector3d::Zero()};
  EXPECT_FALSE(bench.find(truth, right, 0.01).expected);
  const Eigen::Vector3d offset(0.2, -0.2, 0.3);
  const MatchPrior narrow{truth - offset, covariance(0.025, 0.04), Eigen::Vector3d::Zero()};
  const FoundMatch found = bench.find(truth, narrow, 0.01);
  ASSERT_FALSE(found.match.failed);
  ASSERT_TRUE(found.expected);
  EXPECT_TRUE(found.expected->slip.isZero());
  EXPECT_LT(found.expected->d.norm(), 0.2) << "the prior's 99 %";
  EXPECT_LT(found.expected->score, found.match.score);
}

// A map of cells is good to some centimetres, the motion of good wheels to millimetres.
TEST(ScanMatching, WhatFitsNearlyAsWellAtThePriorIsNoSlip) {
  Bench bench(pillars(), {{0, 0, 0}, {0, 0, 3.1}, {0.1, 0, 1.5}, {-0.1, -0.1, -0.5}});
  const Eigen::Vector3d truth(0.1, -0.2, 0.05);
  const Eigen::Vector3d offset(0.04, -0.02, 0.0);
  const Match match = bench.match(truth, {truth - offset, covariance(0.004, 0.004), Eigen::Vector3d::Zero()}, 0.01);
  ASSERT_FALSE(match.failed);
  EXPECT_FALSE(match.searched);
  EXPECT_GT(match.d.norm(), 0.02) << "it lies outside the prior's 99 %";
  EXPECT_TRUE(match.slip.isZero());
}

// People hide most of the walls. What is left fits here badly, and a step aside hardly better.
TEST(ScanMatching, WhatFitsHardlyBetterThanNothingIsNoSlip) {
  Bench bench(pillars(), {{0, 0, 0}, {0, 0, 3.1}, {0.1, 0, 1.5}, {-0.1, -0.1, -0.5}});
  const Eigen::Vector3d aside(0.25, -0.2, 0.1);
  const MatchPrior prior{{0.1, -0.2, 0.05}, covariance(0.025, 0.04), Eigen::Vector3d::Zero()};
  ScanObservation scan = observed(bench.walls, prior.mean, 0.01, 1, bench.yaml);
  const ScanObservation from_aside = observed(bench.walls, prior.mean + aside, 0.01, 2, bench.yaml);
  for (std::size_t i = 0; i < std::min(scan.hits.size(), from_aside.hits.size()); ++i) {
    const std::size_t percent = 37 * i % 100;
    if (percent < 45) scan.hits[i] = from_aside.hits[i];
    if (percent >= 60) scan.hits[i] *= 0.6f;
  }
  bench.window.open(bench.tiles, prior.mean.head<2>(), scan.reach + bench.matcher.margin(prior), kResolution);
  const Match match = bench.matcher.match(bench.window, scan.hits, prior).match;
  MatchSettings no_slips = settings().match;
  no_slips.spread_draws = 0;
  const ScanMatcher usual(no_slips, kResolution);
  const Match other = usual.match(bench.window, scan.hits, prior).match;
  EXPECT_TRUE(match.slip.isZero());
  EXPECT_EQ(match.d, other.d);
}

// Wheels that slipped through a turn: neither search reaches so far, and by the prior's σ (50 nats) the particle would
// lose against one that fits nothing. So it wins as soon as the next scan fits.
TEST(ScanMatching, AfterASlipTheScanIsFoundAtThePriceOfASlip) {
  Bench bench(pillars(), {{0, 0, 0}, {0, 0, 3.1}, {0.1, 0, 1.5}, {-0.1, -0.1, -0.5}});
  const Eigen::Vector3d truth(0.1, -0.2, 0.05);
  const Eigen::Vector3d offset(0.35, -0.3, 0.8);
  const MatchPrior prior{truth - offset, covariance(0.05, 0.07), Eigen::Vector3d::Zero()};
  const Match match = bench.match(truth, prior, 0.01);
  ASSERT_FALSE(match.failed);
  EXPECT_TRUE(match.misfits);
  EXPECT_LT((match.d - offset).norm(), 0.03);
  MatchSettings without = settings().match;
  without.spread_draws = 0;
  bench.matcher = ScanMatcher(without, kResolution);
  const Match failed = bench.match(truth, prior, 0.01);
  ASSERT_TRUE(failed.failed) << "0: none";
  EXPECT_GT(match.log_evidence, failed.log_evidence - 5.0);
  const MatchPrior next{truth, covariance(0.05, 0.07), Eigen::Vector3d::Zero()};
  const double gain = bench.match(truth, next, 0.01).log_evidence - failed.log_evidence;
  EXPECT_GT(match.log_evidence + gain, failed.log_evidence);
}

// The robot turns round in a room of which it has seen one half: what it sees of the other one is new, not wrong.
TEST(ScanMatching, PointsInUnknownPlacesAreNoMisfit) {
  Bench bench(room(), {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}});
  const Eigen::Vector3d truth(0.0, 0.0, 1.4);
  const Match match = bench.match(truth, {truth, covariance(0.05, 0.03), Eigen::Vector3d::Zero()}, 0.01);
  ASSERT_FALSE(match.failed);
  EXPECT_GT(match.score, settings().match.search_score);
  EXPECT_FALSE(match.searched);
  EXPECT_FALSE(match.misfits);
  EXPECT_LT(match.d.norm(), 0.02);
}

// Half of what it sees is behind where it stood before. If that counted as misfits, the scan would fit best there.
TEST(ScanMatching, ARobotThatReversesIsNotHeldBack) {
  const std::vector<Wall> walls = {{-9, -1.01, 3, -1.01},   {3, -1.01, 3, -2.2},    {3, -2.2, 4.1, -2.2},
                                   {4.1, -2.2, 4.1, -1.01}, {4.1, -1.01, 9, -1.01}, {9, -1.01, 9, 1.03},
                                   {9, 1.03, -9, 1.03},     {-9, 1.03, -9, -1.01}};
  for (const double step : {0.5, 1.0, 1.5}) {
    Bench bench(walls, {{0, 0, 0}, {0.3, 0, 0}});
    const Eigen::Vector3d truth(-step, 0.02, 0.03);
    const Match match = bench.match(truth, {truth, covariance(0.05, 0.03), Eigen::Vector3d::Zero()}, 0.01);
    ASSERT_FALSE(match.failed) << step;
    EXPECT_TRUE(match.slip.isZero()) << step;
    EXPECT_LT(match.d.head<2>().norm(), 0.03) << step;
  }
}

/// prior · exp(ηᵀ d − ½ dᵀ Λ d) has its mean at d, and the evidence has the prior's term: also for P without inverse.
TEST(ScanMatching, WhereOnlyTheHeadingIsUnknownEachParticleLooksForItself) {
  // A square looks the same four times; its walls run through the middles of cells.
  constexpr double kHalf = 3.025;
  constexpr double kQuarter = 0.5 * std::numbers::pi;
  const std::vector<Wall> square{{-kHalf, -kHalf, kHalf, -kHalf},
                                 {kHalf, -kHalf, kHalf, kHalf},
                                 {kHalf, kHalf, -kHalf, kHalf},
                                 {-kHalf, kHalf, -kHalf, -kHalf}};
  Bench bench(square, {{0, 0, 0}, {0, 0, kQuarter}, {0, 0, 2 * kQuarter}, {0, 0, 3 * kQuarter}});
  std::set<long> quarters;
  for (int particle = 0; particle < 20; ++particle) {
    const Eigen::Vector3d start(0.0, 0.0, 0.2 * particle - 2.0);
    const Match match = bench.match({0, 0, 0}, {{0, 0, 0}, covariance(0.0, 3.0), start});
    ASSERT_FALSE(match.failed);
    EXPECT_NEAR(std::remainder(match.d.z(), kQuarter), 0.0, 0.02);
    quarters.insert((std::lround(match.d.z() / kQuarter) + 4) % 4);
  }
  EXPECT_GT(quarters.size(), 2u);
}

TEST(ScanMatching, ASearchWithoutBoundsIsRefused) {
  try {
    MatchSettings::read(Config::parse("{ coarse_distance_m: 1000 }", "robot.yaml"), MatchDefaults::cells(kResolution));
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("robot.yaml:1:22: coarse_distance_m"), std::string::npos) << error.what();
  }
}

TEST(ScanMatching, TheRefinedGaussianHasItsMeanAtTheMaximum) {
  Bench bench(room(), {{0, 0, 0}, {4, 0, 1.5}, {-2, -1, -0.5}});
  const Eigen::Vector3d truth(0.1, -0.2, 0.05);
  Eigen::Matrix3d singular = Eigen::Matrix3d::Zero();
  const Eigen::Vector3d direction(0.1, 0.05, 0.02);
  singular = direction * direction.transpose();
  for (const Eigen::Matrix3d& P : {covariance(0.05, 0.03), covariance(0.5, 0.2), singular}) {
    const Match match =
        bench.match(truth, {truth - Eigen::Vector3d(0.05, 0.03, 0.01), P, Eigen::Vector3d::Zero()}, 0.01);
    ASSERT_FALSE(match.failed);
    const Eigen::Vector3d mean =
        P * (Eigen::Matrix3d::Identity() + match.information * P).partialPivLu().solve(match.gradient);
    EXPECT_LT((mean - match.d).norm(), 1e-9);
  }
  const MatchPrior certain{truth, Eigen::Matrix3d::Zero(), Eigen::Vector3d::Zero()};
  EXPECT_TRUE(bench.match(truth, certain).d.isZero());
}

TEST(ScanMatching, TheLikelihoodPeaksWhereTheMatchIsAndItsFloorHolds) {
  Bench bench(room(), {{0, 0, 0}, {4, 0, 1.5}, {-2, -1, -0.5}});
  const Eigen::Vector3d truth(0.1, -0.2, 0.05);
  const MatchPrior prior{truth, covariance(1.0, 0.5), Eigen::Vector3d::Zero()};
  const Match match = bench.match(truth, prior, 0.01);
  const Eigen::Matrix3d P = match.information.inverse();
  const Eigen::Vector3d floor = settings().match.floor;
  for (int i = 0; i < 3; ++i) EXPECT_GE(std::sqrt(P(i, i)), floor(i));
  EXPECT_LT(std::sqrt(P(0, 0)), 0.01);
  EXPECT_LT(std::sqrt(P(2, 2)), 0.005);
}

TEST(ScanMatching, InACorridorThePriorSurvivesAlongIt) {
  // Near and often enough that the walls of the map have no gaps: a gap is a mark along the corridor.
  std::vector<Eigen::Vector3d> poses;
  for (int i = -40; i <= 40; ++i) poses.emplace_back(0.05 * i, 0.0, i % 2 == 0 ? 0.0 : 3.14);
  Bench bench(corridor(), poses, "{ range_max_m: 2 }");
  const Eigen::Vector3d truth(0.3, 0.1, 0.02);
  const Eigen::Vector3d offset(0.4, 0.06, 0.03);
  const MatchPrior prior{truth - offset, covariance(0.5, 0.1), Eigen::Vector3d::Zero()};
  const Match match = bench.match(truth, prior, 0.01);
  ASSERT_FALSE(match.failed);
  EXPECT_NEAR(match.d.y(), offset.y(), 0.015);
  EXPECT_NEAR(match.d.z(), offset.z(), 0.005);
  const Eigen::Matrix3d refined = (prior.P.inverse() + match.information).inverse();
  EXPECT_GT(std::sqrt(refined(0, 0)), 0.8 * 0.5);  // along: what the prior said
  EXPECT_LT(std::sqrt(refined(1, 1)), 0.01);       // across: what the walls say
  EXPECT_NEAR(match.d.x(), 0.0, 0.05);             // nothing there to be seen
}

TEST(ScanMatching, InTheOpenThePriorSurvivesAltogether) {
  const std::vector<Wall> far_pillar{{3.0, -0.05, 3.0, 0.05}};
  Bench bench(far_pillar, {{0, 0, 0}, {0.2, 0.1, 0}});
  const MatchPrior prior{{0.02, -0.03, 0.01}, covariance(0.1, 0.05), Eigen::Vector3d::Zero()};
  const Match match = bench.match({0, 0, 0}, prior);
  const gaussian::Eigen3 eigen = gaussian::eigen(match.information);
  EXPECT_LT(eigen.values.minCoeff(), 1e-3 * eigen.values.maxCoeff());
}

TEST(LikelihoodField, DerivativesAreThoseOfDifferences) {
  Bench bench(room(), {{0, 0, 0}, {4, 0, 1.5}, {-2, -1, -0.5}});
  for (const double sigma : {0.05, 0.12}) {
    const LikelihoodTable table(sigma, kResolution);
    const Eigen::Vector3d pose(0.07, -0.03, 0.02);
    const ScanObservation scan = observed(room(), {0.1, 0.0, 0.0});
    bench.window.open(bench.tiles, pose.head<2>(), scan.reach + 1.0, kResolution);
    // One point at a time: the derivative jumps where a point crosses from cell to cell, and those are left out.
    int compared = 0;
    for (const Eigen::Vector2f& point : scan.hits) {
      const std::vector<Eigen::Vector2f> one{point};
      const FieldFit fit = fit_points(bench.window, table, one, pose, kResolution);
      Eigen::Vector3d differences;
      bool smooth = true;
      for (int i = 0; i < 3; ++i) {
        const double h = 2e-3;
        const Eigen::Vector3d step = h * Eigen::Vector3d::Unit(i);
        const double up = fit_points(bench.window, table, one, pose + step, kResolution).score;
        const double down = fit_points(bench.window, table, one, pose - step, kResolution).score;
        differences(i) = (up - down) / (2.0 * h);
        smooth = smooth && std::abs(up - 2.0 * fit.score + down) < 2e-4;
      }
      if (!smooth) continue;
      ++compared;
      const Eigen::Vector3d expected = differences * (1.0 - fit.score);
      EXPECT_LT((fit.Jtr - expected).norm(), 0.05 * expected.norm() + 0.05);
      EXPECT_NEAR(fit.JtJ.trace(), differences.squaredNorm(), 0.1 * differences.squaredNorm() + 0.05);
    }
    EXPECT_GT(compared, 30);
  }
}

// A scanner of 180° has seen half of a wall. Its end must not pull what is seen of the other half.
TEST(LikelihoodField, MatchesWhereTheMapIsKnown) {
  const std::vector<Wall> wall{{-4, 1.02, 4, 1.02}};
  Bench bench(wall, {{0, 0, 0}});
  const LikelihoodTable table(0.12, kResolution);
  bench.window.open(bench.tiles, {0.0, 0.0}, 6.0, kResolution);
  const auto fit = [&](float x, float y) {
    const std::vector<Eigen::Vector2f> one{{x, y}};
    return fit_points(bench.window, table, one, {0, 0, 0}, kResolution);
  };
  for (const float x : {-0.1f, -0.2f, -0.5f}) {
    const FieldFit seen_first = fit(x, 1.02f);
    EXPECT_EQ(seen_first.unknown, 1.0) << x;
    EXPECT_TRUE(seen_first.Jtr.isZero()) << x;
    EXPECT_DOUBLE_EQ(seen_first.log_likelihood, std::log(0.1)) << x;
  }
  for (const float behind : {0.0f, 0.1f, 0.2f}) {
    const FieldFit seen_again = fit(0.4f, 1.02f + behind);
    EXPECT_EQ(seen_again.unknown, 0.0) << behind;
    EXPECT_EQ(seen_again.Jtr.y() < -0.1, behind > 0.0f) << behind;
  }
  // Between two beams, far off.
  const double beam = std::numbers::pi / 180.0;
  const auto half_way = static_cast<float>(1.02 / std::tan(15.0 * beam));
  EXPECT_EQ(fit(half_way, 1.02f).unknown, 0.0);
}

/// A field with a single known cell.
struct OneKnownCell {
  int x;
  int y;
  bool holds(int, int) const { return true; }
  bool is_known(int column, int row) const { return column == x && row == y; }
};

// Half a degree is a cell at 115 cells, and two at 230: what it takes in only in part is new.
TEST(LikelihoodField, FarOffWhatLiesBetweenTwoBeamsIsKnown) {
  const auto is_known = [](float length, int beside) {
    const OneKnownCell field{static_cast<int>(length) - StoredDistance::kReach, 50 + beside};
    return scan_matching::is_known_before(field, length + 0.5f, 50.5f, length, 0.0f);
  };
  for (const int side : {-1, 1}) {
    EXPECT_TRUE(is_known(100.0f, 0));
    EXPECT_FALSE(is_known(110.0f, side)) << side;
    EXPECT_TRUE(is_known(120.0f, side)) << side;
    EXPECT_FALSE(is_known(225.0f, 2 * side)) << side;
    EXPECT_TRUE(is_known(235.0f, 2 * side)) << side;
  }
}

// What lies behind a wall was not seen, and is no news: no beam gets there.
TEST(LikelihoodField, PointsBehindAWallAreBlocked) {
  const std::vector<Wall> wall{{2.02, -3, 2.02, 3}};
  Bench bench(wall, {{0, 0, 0}});
  bench.window.open(bench.tiles, {0.0, 0.0}, 6.0, kResolution);
  const std::vector<Eigen::Vector2f> points{{2.0f, 0.1f}, {4.0f, 0.1f}, {1.0f, 0.1f}, {-1.0f, 0.5f}};
  const auto count = [&](scan_matching::Ends ends) {
    return scan_matching::count_blocked(bench.window, points, {0, 0, 0}, kResolution, ends);
  };
  EXPECT_EQ(count(scan_matching::Ends::in_unknown), 1u);
  EXPECT_EQ(count(scan_matching::Ends::anywhere), 1u);
}

TEST(LikelihoodField, IsOneOnAWallAndFallsAsAGaussian) {
  const LikelihoodTable table(0.1, kResolution);
  EXPECT_FLOAT_EQ(table[0], 1.0f);
  EXPECT_NEAR(table[2 * Tile::kDistanceSteps], std::exp(-0.5), 1e-6);
  EXPECT_FLOAT_EQ(table[Tile::kFar], table[Tile::kReach * Tile::kDistanceSteps]);
}

}  // namespace
}  // namespace waymark::occupancy_grid_test
