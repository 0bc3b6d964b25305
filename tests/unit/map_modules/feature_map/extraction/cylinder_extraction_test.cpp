// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "tests/unit/map_modules/feature_map/feature_map_bench.hpp"
#include "waymark/base/error.hpp"

namespace waymark::feature_map {
namespace {

using feature_map_test::kDegree;
using feature_map_test::scan_of;
using feature_map_test::settings_of;
using feature_map_test::World;

const std::string kExtraction =
    "{ attributes: [radius], extraction: { range_min_m: 0.5, range_max_m: 30, no_return_m: 80, segment_jump_m: 0.5, "
    "background_m: 1,"
    " width_max_m: 1.2, bright_above: 0 } }";

FeatureObservation extract(const LaserScan& scan, const Pose& T_base_sensor = {}) {
  return extract_cylinders(scan, T_base_sensor, settings_of(kExtraction));
}

FeatureObservation extract(const World& world) { return extract(scan_of(world)); }

/// How wrong a radius can be that is counted in beams: one beam more or less, and the round front taken as flat.
double radius_error_bound(double distance, double radius) { return 0.5 * kDegree * distance + 0.1 * radius; }

const World::Wall kBackWall{{15.0, -40.0}, {15.0, 40.0}};

TEST(CylinderExtraction, FindsACylinderInFrontOfAWall) {
  const auto found = extract(World{{{{6.0, 1.0}, 0.2}}, {kBackWall}});
  ASSERT_EQ(found.detections.size(), 1u);
  EXPECT_NEAR(found.detections[0].xyr.x(), 6.0, 0.08);
  EXPECT_NEAR(found.detections[0].xyr.y(), 1.0, 0.05);
  EXPECT_NEAR(found.detections[0].xyr.z(), 0.2, radius_error_bound(6.1, 0.2));
}

TEST(CylinderExtraction, FindsACylinderInTheOpen) {
  EXPECT_EQ(extract(World{{{{6.0, 1.0}, 0.2}}, {}}).detections.size(), 1u);
}

TEST(CylinderExtraction, AWallRightBehindHidesACylinder) {
  EXPECT_TRUE(extract(World{{{{14.5, 1.0}, 0.2}}, {kBackWall}}).detections.empty());
}

TEST(CylinderExtraction, LooksNoFartherThanRangeMax) {
  EXPECT_EQ(extract(World{{{{29.5, 0.0}, 0.3}}, {}}).detections.size(), 1u);
  EXPECT_TRUE(extract(World{{{{30.5, 0.0}, 0.3}}, {}}).detections.empty());
}

TEST(CylinderExtraction, WhatIsNearerThanRangeMinIsTheRobotItself) {
  EXPECT_TRUE(extract(World{{{{0.5, 0.0}, 0.05}}, {}}).detections.empty());
  EXPECT_EQ(extract(World{{{{0.6, 0.0}, 0.05}}, {}}).detections.size(), 1u);
}

TEST(CylinderExtraction, TheRobotsOwnPartsHideTheSurroundingsOfACylinder) {
  LaserScan scan = scan_of(World{{{{6.0, 0.0}, 0.2}}, {}});
  const auto whole = extract(scan);
  ASSERT_EQ(whole.detections.size(), 1u);
  scan.ranges_m[static_cast<std::size_t>(whole.detections[0].last_beam + 1)] = 0.2f;
  EXPECT_TRUE(extract(scan).detections.empty());
}

TEST(CylinderExtraction, AScanWithoutReturnsHasNoDetections) {
  const auto found = extract(World{});
  EXPECT_TRUE(found.detections.empty());
  EXPECT_EQ(found.view.ranges.size(), 361u);
  EXPECT_TRUE(std::isinf(found.view.ranges[180]));  // free, not blind
}

TEST(CylinderExtraction, NotANumberIsBlindNotFree) {
  LaserScan scan = scan_of(World{});
  scan.ranges_m[100] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(extract(scan).view.ranges[100], 0.0f);
}

TEST(CylinderExtraction, InfinityIsNoReturn) {
  LaserScan scan = scan_of(World{{{{6.0, 0.0}, 0.2}}, {}});
  for (float& r : scan.ranges_m) r = r > 80.0f ? std::numeric_limits<float>::infinity() : r;
  EXPECT_EQ(extract(scan).detections.size(), 1u);
}

TEST(CylinderExtraction, AScanWithoutBeamsIsUnusable) { EXPECT_THROW(extract(LaserScan{}), DataError); }

TEST(CylinderExtraction, ACylinderThatTheBorderOfTheScanCutsIsNotMeasured) {
  EXPECT_TRUE(extract(World{{{{0.0, 5.0}, 0.3}}, {}}).detections.empty());
  EXPECT_TRUE(extract(World{{{{0.0, -5.0}, 0.3}}, {}}).detections.empty());
}

TEST(CylinderExtraction, TwoCylindersCloseTogetherAreTwo) {
  const auto found = extract(World{{{{6.0, -0.3}, 0.15}, {{6.0, 0.3}, 0.15}}, {kBackWall}});
  ASSERT_EQ(found.detections.size(), 2u);
  EXPECT_NEAR(found.detections[0].xyr.y(), -0.3, 0.05);
  EXPECT_NEAR(found.detections[1].xyr.y(), 0.3, 0.05);
}

TEST(CylinderExtraction, OfTwoCylindersBehindEachOtherOnlyTheFrontIsMeasured) {
  const auto found = extract(World{{{{5.0, 0.0}, 0.2}, {{7.0, 0.3}, 0.2}}, {kBackWall}});
  ASSERT_EQ(found.detections.size(), 1u);
  EXPECT_NEAR(found.detections[0].xyr.x(), 5.0, 0.08);
}

TEST(CylinderExtraction, WallsAndTheirCornersAreNoCylinders) {
  const World::Wall along{{-30.0, 2.0}, {30.0, 2.0}};
  EXPECT_TRUE(extract(World{{}, {kBackWall}}).detections.empty());
  EXPECT_TRUE(extract(World{{}, {along}}).detections.empty());             // at grazing incidence
  EXPECT_TRUE(extract(World{{}, {along, kBackWall}}).detections.empty());  // a corner of a room
  EXPECT_TRUE(
      extract(World{{}, {{{5.0, 0.0}, {9.0, 4.0}}, {{5.0, 0.0}, {9.0, -4.0}}}}).detections.empty());  // of a house
}

TEST(CylinderExtraction, WiderThanWidthMaxIsNoCylinder) {
  EXPECT_EQ(extract(World{{{{8.0, 0.0}, 0.5}}, {}}).detections.size(), 1u);
  EXPECT_TRUE(extract(World{{{{8.0, 0.0}, 0.7}}, {}}).detections.empty());
}

TEST(CylinderExtraction, FewerThanMinBeamsAreNoise) {
  const auto settings = settings_of("{ extraction: { min_beams: 4 } }");
  const auto count = [&](double distance) {
    return extract_cylinders(scan_of(World{{{{distance, 0.0}, 0.1}}, {}}), {}, settings).detections.size();
  };
  EXPECT_EQ(count(4.0), 1u);   // 2.9 degrees: five or six beams
  EXPECT_EQ(count(15.0), 0u);  // 0.8 degrees: one or two
}

TEST(CylinderExtraction, TheExtrinsicsTakeDetectionsToTheBase) {
  const Pose T_base_sensor{so3::from_rpy(0.0, 0.0, 0.5 * std::numbers::pi), {1.0, 2.0, 0.3}};
  const LaserScan scan = scan_of(World{{{{6.0, 1.0}, 0.2}}, {}});
  const auto in_sensor = extract(scan);
  const auto in_base = extract(scan, T_base_sensor);
  ASSERT_EQ(in_base.detections.size(), 1u);
  EXPECT_NEAR(in_base.detections[0].xyr.x(), 1.0 - in_sensor.detections[0].xyr.y(), 1e-9);
  EXPECT_NEAR(in_base.detections[0].xyr.y(), 2.0 + in_sensor.detections[0].xyr.x(), 1e-9);
  EXPECT_NEAR(in_base.detections[0].R(0, 0), in_sensor.detections[0].R(1, 1), 1e-12);
}

/// Beams that are measured one after the other, from a robot that drives and turns, say where the cylinder is seen from
/// where the scan began.
TEST(CylinderExtraction, ASweepIsSeenFromWhereItBegan) {
  const MotionWindow motion{{1.5, 0.2, 0.0}, {0.0, 0.0, 1.2}};
  const Pose T_base_sensor = Pose::planar(0.5, 0.1, 0.3);
  const Eigen::Vector3d cylinder(4.0, 2.5, 0.0);  // in the base's frame at the stamp
  LaserScan scan;
  scan.start_rad = -90.0 * kDegree;
  scan.step_rad = 0.25 * kDegree;
  scan.beam_interval_s = 1e-4;
  for (int k = 0; k <= 720; ++k) {
    const Pose T_base_now = motion.relative(k * scan.beam_interval_s) * T_base_sensor;
    const World world{{{(T_base_now.inverse() * cylinder).head<2>(), 0.2}}, {}};
    const double range = world.cast(scan.start_rad + k * scan.step_rad);
    scan.ranges_m.push_back(range < 60.0 ? static_cast<float>(range) : 81.0f);
  }
  const FeatureMapSettings settings = settings_of(kExtraction);
  const auto error = [&](const MotionWindow& known) {
    ScanView view = view_of(scan, T_base_sensor, settings.extraction, known);
    const auto candidates = examine(view, settings.extraction);
    const auto found = observe(scan, std::move(view), candidates, nullptr, T_base_sensor, settings);
    EXPECT_EQ(found.detections.size(), 1u);
    return (found.detections.at(0).xyr.head<2>() - cylinder.head<2>()).norm();
  };
  EXPECT_LT(error(motion), 0.03);
  EXPECT_GT(error({}), 0.15);
  scan.beam_interval_s = 0.005;
  EXPECT_THROW(error(motion), DataError);
  scan.beam_interval_s = 0.0;
  EXPECT_EQ(error(motion), error({}));
}

TEST(CylinderExtraction, AGlintMakesABrightSignature) {
  LaserScan scan = scan_of(World{{{{6.0, -2.0}, 0.2}, {{6.0, 2.0}, 0.2}}, {}});
  scan.intensities.assign(scan.ranges_m.size(), 0.0f);
  const auto plain = extract(scan);
  ASSERT_EQ(plain.detections.size(), 2u);
  scan.intensities[static_cast<std::size_t>(plain.detections[1].first_beam)] = 3.0f;
  const auto found = extract(scan);
  EXPECT_GT(found.detections[0].signature[0], 0.9f);
  EXPECT_GT(found.detections[1].signature[1], 0.9f);
}

// --- why candidates are dropped ------------------------------------------------------------------------------------

/// The verdict of the only segment of a scan.
Verdict verdict_of(const LaserScan& scan, const std::string& more = "") {
  const auto settings =
      settings_of("{ extraction: { range_min_m: 0.5, range_max_m: 20, width_max_m: 1.2" + more + " } }").extraction;
  const auto candidates = examine(view_of(scan, {}, settings), settings);
  EXPECT_EQ(candidates.size(), 1u);
  return candidates.at(0).verdict;
}

/// The verdict of the segment that lies at `bearing`, 0 being ahead.
Verdict verdict_at(double bearing, const World& world, const std::string& more = "") {
  const auto settings =
      settings_of("{ extraction: { range_min_m: 0.5, range_max_m: 20, width_max_m: 1.2" + more + " } }").extraction;
  const int beam = static_cast<int>(std::lround((bearing + 90.0 * kDegree) / (0.5 * kDegree)));
  for (const Candidate& candidate : examine(view_of(scan_of(world), {}, settings), settings)) {
    if (candidate.first_beam <= beam && beam <= candidate.last_beam) return candidate.verdict;
  }
  ADD_FAILURE() << "nothing at " << bearing;
  return Verdict::accepted;
}

TEST(Examine, EverySegmentHasItsVerdict) {
  const World::Cylinder trunk{{8.0, 0.0}, 0.2};
  EXPECT_EQ(verdict_of(scan_of(World{{trunk}, {}})), Verdict::accepted);
  EXPECT_EQ(verdict_of(scan_of(World{{{{25.0, 0.0}, 0.4}}, {}})), Verdict::too_far);
  EXPECT_EQ(verdict_of(scan_of(World{{{{8.0, 0.0}, 0.8}}, {}})), Verdict::too_wide);
  // Narrow, but its five beams lie up to 1.6 m behind each other.
  LaserScan wall = scan_of(World{{{{8.0, 0.0}, 0.15}}, {}});
  const auto middle = static_cast<std::ptrdiff_t>(wall.ranges_m.size()) / 2;
  for (std::ptrdiff_t k = -2; k <= 2; ++k)
    wall.ranges_m[static_cast<std::size_t>(middle + k)] = 8.0f + 0.4f * static_cast<float>(k);
  EXPECT_EQ(verdict_of(wall), Verdict::too_wide);
  EXPECT_EQ(verdict_of(scan_of(World{{trunk}, {}}), ", min_beams: 20"), Verdict::too_few_beams);
  EXPECT_EQ(verdict_of(scan_of(World{{{{0.0, 8.0}, 0.2}}, {}})), Verdict::hidden);
  EXPECT_EQ(verdict_at(0.0, World{{trunk}, {{{8.6, -20.0}, {8.6, 20.0}}}}), Verdict::no_background);
}

TEST(Examine, ABlindNeighbourHidesAndDoesNotCrowd) {
  LaserScan scan = scan_of(World{{{{8.0, 0.0}, 0.2}}, {}});
  const auto settings = settings_of("{ extraction: { range_min_m: 0.5, isolation_m: 3 } }").extraction;
  const int last = examine(view_of(scan, {}, settings), settings).at(0).last_beam;
  scan.ranges_m[static_cast<std::size_t>(last + 1)] = 0.2f;
  EXPECT_EQ(examine(view_of(scan, {}, settings), settings).at(0).verdict, Verdict::hidden);
  scan.ranges_m[static_cast<std::size_t>(last + 1)] = 81.0f;
  scan.ranges_m[static_cast<std::size_t>(last + 4)] = 0.2f;
  EXPECT_EQ(examine(view_of(scan, {}, settings), settings).at(0).verdict, Verdict::accepted);
}

TEST(Examine, TwoTrunksWithinTheIsolationCrowdEachOther) {
  const auto pair = [](double gap) { return World{{{{8.0, 0.0}, 0.2}, {{8.0, gap}, 0.2}}, {}}; };
  EXPECT_EQ(verdict_at(0.0, pair(1.5), ", isolation_m: 2"), Verdict::crowded);
  EXPECT_EQ(verdict_at(std::atan2(1.5, 8.0), pair(1.5), ", isolation_m: 2"), Verdict::crowded);
  EXPECT_EQ(verdict_at(0.0, pair(3.0), ", isolation_m: 2"), Verdict::accepted);
  EXPECT_EQ(verdict_at(0.0, pair(1.5)), Verdict::accepted);  // isolation is not asked unless given
}

TEST(Examine, IsolationIsADistanceInThePlaneNotAcrossTheBeam) {
  const World behind{{{{5.0, 0.0}, 0.2}, {{12.0, 0.8}, 0.2}}, {}};  // neighbours in the scan, 7 m apart
  EXPECT_EQ(verdict_at(0.0, behind, ", isolation_m: 3"), Verdict::accepted);
  const World wall{{{{8.0, 0.0}, 0.2}}, {{{10.5, -20.0}, {10.5, 20.0}}}};
  EXPECT_EQ(verdict_at(0.0, wall, ", isolation_m: 3"), Verdict::crowded);
  EXPECT_EQ(verdict_at(0.0, wall, ", isolation_m: 2"), Verdict::accepted);
}

TEST(Examine, IsolationLooksAllRoundACandidateNearerThanIt) {
  const World beside{{{{1.0, 0.0}, 0.1}, {{0.3, -1.5}, 0.1}}, {}};
  EXPECT_EQ(verdict_at(0.0, beside, ", isolation_m: 2"), Verdict::crowded);
  EXPECT_EQ(verdict_at(0.0, beside, ", isolation_m: 1"), Verdict::accepted);
}

// --- size and place over the range
// --------------------------------------------------------------------------------------

class CylinderAtRange : public ::testing::TestWithParam<double> {};

TEST_P(CylinderAtRange, RadiusAndPlaceAreRightToTheWidthOfABeam) {
  const double distance = GetParam();
  for (const double radius : {0.1, 0.2, 0.3}) {
    double sum = 0.0;
    constexpr int kBearings = 40;  // spread over the step between two beams
    for (int k = 0; k < kBearings; ++k) {
      const double bearing = (10.0 + 0.5 * k / kBearings) * kDegree;
      const Eigen::Vector2d center = distance * Eigen::Vector2d(std::cos(bearing), std::sin(bearing));
      const auto found = extract(World{{{center, radius}}, {}});
      ASSERT_EQ(found.detections.size(), 1u) << radius;
      const Eigen::Vector3d& xyr = found.detections[0].xyr;
      const double bound = radius_error_bound(distance, radius);
      ASSERT_NEAR(xyr.z(), radius, bound);
      ASSERT_LT((xyr.head<2>() - center).norm(), bound + 0.05) << radius;
      sum += xyr.z();
    }
    // Beams count the width without bias; what remains is the curvature of the front.
    EXPECT_NEAR(sum / kBearings, radius, 0.02 * radius + 0.01) << radius;
  }
}

INSTANTIATE_TEST_SUITE_P(Ranges, CylinderAtRange, ::testing::Values(2.0, 4.0, 7.0, 10.0));

TEST(MakeDetection, NoiseIsThatOfRangeBearingAndRadiusInTheBase) {
  const DetectionNoise noise{.range = 0.05, .bearing = 0.01, .tangential = 0.03, .radius = 0.08};
  const Pose T_base_sensor{so3::from_rpy(0.0, 0.0, 0.7), {0.4, -0.1, 0.2}};
  const Eigen::Vector3d drb(5.0, 0.6, 0.2);  // surface range, bearing, radius
  const auto at = [&](const Eigen::Vector3d& x) { return make_detection(x[0], x[1], x[2], T_base_sensor, noise).xyr; };
  Eigen::Matrix3d J;
  for (int i = 0; i < 3; ++i)
    J.col(i) = (at(drb + 1e-6 * Eigen::Vector3d::Unit(i)) - at(drb - 1e-6 * Eigen::Vector3d::Unit(i))) / 2e-6;
  const Eigen::Vector3d across(-std::sin(0.6 + 0.7), std::cos(0.6 + 0.7), 0.0);
  const Eigen::Matrix3d expected =
      J * Eigen::Vector3d(0.05 * 0.05, 0.01 * 0.01, 0.08 * 0.08).asDiagonal() * J.transpose() +
      0.03 * 0.03 * across * across.transpose();
  const Detection detection = make_detection(drb[0], drb[1], drb[2], T_base_sensor, noise);
  EXPECT_LT((detection.R - expected).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_NEAR(detection.xyr.z(), 0.2, 1e-12);
  EXPECT_NEAR((detection.xyr.head<2>() - Eigen::Vector2d(0.4, -0.1)).norm(), 5.2, 1e-12);
}

TEST(MakeDetection, NoiseOfTheRangeGrowsWithIt) {
  const DetectionNoise noise{.range = 0.03, .bearing = 1e-3, .tangential = 0.0, .radius = 0.0, .range_share = 0.01};
  EXPECT_NEAR(make_detection(4.0, 0.0, 0.0, {}, noise).R(0, 0), 0.05 * 0.05, 1e-12);
}

TEST(MakeDetection, WithoutTheAttributeTheRadiusHasNoNoise) {
  const auto settings = settings_of("{ attributes: [] }");
  const auto found = extract_cylinders(scan_of(World{{{{6.0, 1.0}, 0.2}}, {}}), {}, settings);
  ASSERT_EQ(found.detections.size(), 1u);
  EXPECT_EQ(found.detections[0].R(2, 2), 0.0);
}

}  // namespace
}  // namespace waymark::feature_map
