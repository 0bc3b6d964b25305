// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "estimation/georeference.hpp"
#include "unit/sensors/sensor_bench.hpp"

namespace waymark {
namespace {

using sensor_test::make_sensor;
using sensor_test::measurement_of;
using sensor_test::refusal;
using sensor_test::SensorBench;
using ::testing::HasSubstr;

constexpr double kExact = 1e-12;
constexpr double kDegree = std::numbers::pi / 180.0;

SensorBench dgps(const std::string& more, StateLayout::Motion motion = StateLayout::Motion::planar) {
  const std::string offset = more.find("offset_sigma_m") == std::string::npos ? ", offset_sigma_m: 0" : "";
  return SensorBench(make_sensor("dgps", "{ base_p_antenna_m: [0.5, -0.2, 1.1], sigma_m: 0.3" + offset + more + " }"),
                     motion);
}

GnssFix local(double east, double north, double up = 0.0) {
  GnssFix fix;
  fix.p_map_antenna = {east, north, up};
  return fix;
}

GnssFix geodetic(double latitude, double longitude, double height = GnssFix::kUnknown) {
  GnssFix fix;
  fix.latitude_deg = latitude;
  fix.longitude_deg = longitude;
  fix.height_m = height;
  return fix;
}

double sigma_of(const std::string& more, const GnssFix& fix) {
  auto bench = dgps(more);
  return std::sqrt(bench.feed(measurement_of(fix)).R(0, 0));
}

TEST(Dgps, TheLeverArmTurnsWithTheRobot) {
  auto bench = dgps("");
  bench.mean.T_map_base = Pose::planar(10.0, 20.0, 0.5 * std::numbers::pi);  // forward is north, left is west
  const auto& model = bench.feed(measurement_of(local(10.0 + 0.2, 20.0 + 0.5)));
  ASSERT_EQ(model.rows(), 2);
  EXPECT_NEAR(model.residual.norm(), 0.0, kExact);
}

TEST(Dgps, PlanarMotionLeavesTheHeightOut) {
  auto bench = dgps("");
  EXPECT_EQ(bench.feed(measurement_of(local(1.0, 2.0, 55.0))).rows(), 2);
}

TEST(Dgps, SpatialMotionUsesTheHeight) {
  auto bench = dgps("", StateLayout::Motion::spatial);
  const auto& model = bench.feed(measurement_of(local(0.5, -0.2, 4.1)));
  ASSERT_EQ(model.rows(), 3);
  EXPECT_NEAR(model.residual[2], 3.0, kExact);
  EXPECT_NEAR(model.R(2, 2), 0.36, kExact);  // twice sigma_m by default
}

TEST(Dgps, AFixWithoutHeightHasTwoRowsInSpace) {
  auto bench = dgps("", StateLayout::Motion::spatial);
  EXPECT_EQ(bench.feed(measurement_of(local(1.0, 2.0, GnssFix::kUnknown))).rows(), 2);
}

TEST(Dgps, TheOffsetStateIsPartOfTheExpectation) {
  auto bench = dgps(", offset_sigma_m: 0.7, offset_tau_s: 60");
  bench.mean.block << 0.4, -0.3;
  const auto& model = bench.feed(measurement_of(local(0.5 + 0.4, -0.2 - 0.3)));
  EXPECT_NEAR(model.residual.norm(), 0.0, kExact);
  ASSERT_TRUE(model.uses_block());
  EXPECT_TRUE(model.get_block().isIdentity());
}

TEST(Dgps, TheOffsetIsAGaussMarkovProcess) {
  const auto block = dgps(", offset_sigma_m: 0.7, offset_tau_s: 60").sensor().block();
  ASSERT_EQ(block.size(), 2u);
  for (const BlockState& state : block) {
    EXPECT_EQ(state.initial_sigma, 0.7);
    EXPECT_EQ(state.stationary_sigma, 0.7);
    EXPECT_EQ(state.tau_s, 60.0);
  }
}

TEST(Dgps, TheHeightCanHaveAnOffsetOfItsOwn) {
  auto bench = dgps(", offset_sigma_m: 0.7, offset_vertical_sigma_m: 1.5", StateLayout::Motion::spatial);
  ASSERT_EQ(bench.sensor().block().size(), 3u);
  EXPECT_EQ(bench.sensor().block()[2].stationary_sigma, 1.5);
  bench.mean.block << 0.4, -0.3, 2.0;
  const auto& model = bench.feed(measurement_of(local(0.5 + 0.4, -0.2 - 0.3, 1.1 + 2.0)));
  EXPECT_NEAR(model.residual.norm(), 0.0, kExact);
  EXPECT_TRUE(model.get_block().isIdentity());
}

TEST(Dgps, InThePlaneTheOffsetOfTheHeightIsLeftAlone) {
  auto bench = dgps(", offset_sigma_m: 0.7, offset_vertical_sigma_m: 1.5");
  const auto& model = bench.feed(measurement_of(local(0.5, -0.2)));
  ASSERT_EQ(model.rows(), 2);
  EXPECT_TRUE(model.get_block().isApprox((Eigen::MatrixXd(2, 3) << 1, 0, 0, 0, 1, 0).finished()));
}

TEST(Dgps, WithoutAnOffsetThereAreNoStates) { EXPECT_TRUE(dgps("").sensor().block().empty()); }

// --- classes of receivers: nothing is given but geometry ------------------------------------------------------------

SensorBench plain(const std::string& more = "") {
  return SensorBench(make_sensor("dgps", "{ base_p_antenna_m: none" + more + " }"));
}

/// White and slow σ of a fix: of the measurement, and of the offset's state as it enters.
std::pair<double, double> errors_of(const std::string& more, const GnssFix& fix) {
  auto bench = plain(more);
  const double usual = bench.sensor().block().at(0).stationary_sigma;
  const auto& model = bench.feed(measurement_of(fix));
  return {std::sqrt(model.R(0, 0)), usual * model.get_block()(0, 0)};
}

TEST(DgpsClasses, ByDefaultAReceiverHasASlowErrorOfItsOwn) {
  const auto block = plain().sensor().block();
  ASSERT_EQ(block.size(), 2u);
  EXPECT_EQ(block[0].stationary_sigma, 1.0);
  EXPECT_EQ(block[0].tau_s, 60.0);
  EXPECT_EQ(plain(", receiver: rtk_fixed").sensor().block().at(0).stationary_sigma, 0.02);
}

TEST(DgpsClasses, TheTypeOfAFixSaysHowLargeItsErrorsAre) {
  const std::pair<GnssFix::Type, double> white[] = {{GnssFix::Type::unknown, 0.5},
                                                    {GnssFix::Type::single, 0.5},
                                                    {GnssFix::Type::differential, 0.25},
                                                    {GnssFix::Type::rtk_float, 0.1},
                                                    {GnssFix::Type::rtk_fixed, 0.01}};
  for (const auto& [type, sigma] : white) {
    GnssFix fix = local(0.0, 0.0);
    fix.type = type;
    const auto [white_sigma, slow_sigma] = errors_of("", fix);
    EXPECT_NEAR(white_sigma, sigma, kExact);
    EXPECT_NEAR(slow_sigma, 2.0 * sigma, kExact);
  }
}

TEST(DgpsClasses, TheReceiversClassCountsWhereAFixStatesNoType) {
  const auto [white_sigma, slow_sigma] = errors_of(", receiver: rtk_float", local(0.0, 0.0));
  EXPECT_NEAR(white_sigma, 0.1, kExact);
  EXPECT_NEAR(slow_sigma, 0.2, kExact);
  GnssFix lost = local(0.0, 0.0);
  lost.type = GnssFix::Type::single;
  EXPECT_NEAR(errors_of(", receiver: rtk_float", lost).second, 1.0, kExact);
}

TEST(DgpsClasses, AGivenNoiseHasASlowErrorAsLarge) {
  const auto [white_sigma, slow_sigma] = errors_of(", sigma_m: 0.02", local(0.0, 0.0));
  EXPECT_NEAR(white_sigma, 0.02, kExact);
  EXPECT_NEAR(slow_sigma, 0.02, kExact);
}

TEST(DgpsClasses, WhatAReceiverReportsIsItsWholeError) {
  GnssFix fix = local(0.0, 0.0);
  fix.sigma_horizontal_m = 4.0;
  const auto [white_sigma, slow_sigma] = errors_of("", fix);
  EXPECT_NEAR(std::hypot(white_sigma, slow_sigma), 4.0, 0.1);
  EXPECT_NEAR(slow_sigma, 2.0 * white_sigma, kExact);
}

TEST(DgpsClasses, AGivenOffsetIsThatOfEveryFix) {
  GnssFix fix = local(0.0, 0.0);
  fix.type = GnssFix::Type::rtk_fixed;
  fix.sigma_horizontal_m = 4.0;
  const auto [white_sigma, slow_sigma] = errors_of(", sigma_m: 0.3, offset_sigma_m: 0.7", fix);
  EXPECT_NEAR(white_sigma, 4.0, kExact);
  EXPECT_EQ(slow_sigma, 0.7);
}

TEST(DgpsClasses, TheStartHintHasBothParts) {
  const auto hint = plain().sensor().start_hint(measurement_of(local(3.0, 4.0)), nullptr);
  ASSERT_TRUE(hint);
  EXPECT_NEAR(hint->sigma_m, std::hypot(0.5, 1.0), kExact);
  EXPECT_EQ(hint->slow_sigma_m, 1.0);
  EXPECT_EQ(hint->slow_tau_s, 60.0);
}

// --- geodetic: radii of curvature of the WGS-84 ellipsoid, a = 6378137 m, f = 1/298.257223563
// --------------------------

double meridian_radius(double latitude) {
  const double e2 = (2.0 - 1.0 / 298.257223563) / 298.257223563;
  const double s = std::sin(latitude * kDegree);
  return 6378137.0 * (1.0 - e2) / std::pow(1.0 - e2 * s * s, 1.5);
}

double parallel_radius(double latitude) {
  const double e2 = (2.0 - 1.0 / 298.257223563) / 298.257223563;
  const double s = std::sin(latitude * kDegree);
  return 6378137.0 * std::cos(latitude * kDegree) / std::sqrt(1.0 - e2 * s * s);
}

class DgpsAtLatitude : public ::testing::TestWithParam<double> {};

TEST_P(DgpsAtLatitude, AThousandthOfADegreeNorthIsTheMeridiansArc) {
  const double latitude = GetParam();
  auto bench = dgps("");
  bench.datum = Datum{latitude, 8.0, 100.0};
  const auto& model = bench.feed(measurement_of(geodetic(latitude + 0.001, 8.0, 100.0)));
  const double arc = (meridian_radius(latitude) + 100.0) * 0.001 * kDegree;
  EXPECT_NEAR(model.residual[1] + (-0.2), arc, 1e-3);  // the antenna is 0.2 m to the right
  EXPECT_NEAR(model.residual[0] + 0.5, 0.0, 1e-3);
}

TEST_P(DgpsAtLatitude, AThousandthOfADegreeEastIsTheParallelsArc) {
  const double latitude = GetParam();
  auto bench = dgps("");
  bench.datum = Datum{latitude, 8.0, 0.0};
  const auto& model = bench.feed(measurement_of(geodetic(latitude, 8.001, 0.0)));
  EXPECT_NEAR(model.residual[0] + 0.5, parallel_radius(latitude) * 0.001 * kDegree, 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Latitudes, DgpsAtLatitude, ::testing::Values(-33.9, 0.0, 49.0157, 65.0));

// Published lengths of a degree of latitude: 110.574 km at the equator, 111.132 km at 45°, 111.694 km at the pole.
TEST(Dgps, ADegreeOfLatitudeHasThePublishedLength) {
  const std::vector<std::pair<double, double>> published = {{0.0, 110.574}, {45.0, 111.132}, {89.0, 111.694}};
  for (const auto& [latitude, metres_per_thousandth] : published) {
    auto bench = dgps("");
    bench.datum = Datum{latitude, 0.0, 0.0};
    const double north = bench.feed(measurement_of(geodetic(latitude + 0.001, 0.0, 0.0))).residual[1] - 0.2;
    EXPECT_NEAR(north, metres_per_thousandth, 2e-3) << latitude;
  }
}

TEST(Dgps, TheHeightCountsFromTheDatum) {
  auto bench = dgps("", StateLayout::Motion::spatial);
  bench.datum = Datum{49.0, 8.0, 100.0};
  EXPECT_NEAR(bench.feed(measurement_of(geodetic(49.0, 8.0, 107.0))).residual[2], 7.0 - 1.1, 1e-6);
}

TEST(Dgps, AGeodeticFixWithoutDatumIsUnusable) {
  auto bench = dgps("");
  EXPECT_THROW(bench.feed(measurement_of(geodetic(49.0, 8.0))), DataError);
}

// --- noise
// -------------------------------------------------------------------------------------------------------------

TEST(Dgps, SigmaIsTheFloorOfWhatTheFixReports) {
  GnssFix fix = local(1.0, 2.0);
  EXPECT_NEAR(sigma_of("", fix), 0.3, kExact);
  fix.sigma_horizontal_m = 0.8;
  EXPECT_NEAR(sigma_of("", fix), 0.8, kExact);
  fix.sigma_horizontal_m = 0.01;
  EXPECT_NEAR(sigma_of("", fix), 0.3, kExact);
}

TEST(Dgps, TheReportedSigmaCanBeIgnored) {
  GnssFix fix = local(1.0, 2.0);
  fix.sigma_horizontal_m = 0.8;
  EXPECT_NEAR(sigma_of(", use_reported_sigma: false", fix), 0.3, kExact);
}

TEST(Dgps, SigmaGrowsWithTheHdop) {
  GnssFix fix = local(1.0, 2.0);
  fix.hdop = 2.5;
  EXPECT_NEAR(sigma_of(", sigma_per_hdop_m: 0.4", fix), 1.0, kExact);
  fix.hdop = 0.5;
  EXPECT_NEAR(sigma_of(", sigma_per_hdop_m: 0.4", fix), 0.3, kExact);
}

TEST(Dgps, TheFixTypeSetsALeastSigma) {
  const std::string by_type = ", sigma_by_type_m: { single: 3, differential: 0.5, rtk_float: 0.4, rtk_fixed: 0.02 }";
  GnssFix fix = local(1.0, 2.0);
  const std::vector<std::pair<GnssFix::Type, double>> expected = {{GnssFix::Type::single, 3.0},
                                                                  {GnssFix::Type::differential, 0.5},
                                                                  {GnssFix::Type::rtk_float, 0.4},
                                                                  {GnssFix::Type::rtk_fixed, 0.3},
                                                                  {GnssFix::Type::unknown, 0.3}};
  for (const auto& [type, sigma] : expected) {
    fix.type = type;
    EXPECT_NEAR(sigma_of(by_type, fix), sigma, kExact) << static_cast<int>(type);
  }
}

TEST(Dgps, TheVerticalSigmaIsTheReportedOneIfLarger) {
  auto bench = dgps(", sigma_vertical_m: 0.5", StateLayout::Motion::spatial);
  GnssFix fix = local(1.0, 2.0, 3.0);
  EXPECT_NEAR(bench.feed(measurement_of(fix)).R(2, 2), 0.25, kExact);
  fix.sigma_vertical_m = 2.0;
  EXPECT_NEAR(bench.feed(measurement_of(fix)).R(2, 2), 4.0, kExact);
}

// --- unusable fixes
// ----------------------------------------------------------------------------------------------------

TEST(Dgps, NoFixIsUnusable) {
  auto bench = dgps("");
  GnssFix fix = local(1.0, 2.0);
  fix.type = GnssFix::Type::none;
  EXPECT_THROW(bench.feed(measurement_of(fix)), DataError);
  EXPECT_THROW(bench.sensor().start_hint(measurement_of(fix), nullptr), DataError);
}

TEST(Dgps, LatitudeAndLongitudeZeroIsAReceiverWithoutAFix) {
  auto bench = dgps("");
  EXPECT_THROW(bench.feed(measurement_of(geodetic(0.0, 0.0))), DataError);
  EXPECT_THROW(bench.sensor().start_hint(measurement_of(geodetic(0.0, 0.0)), nullptr), DataError);
}

TEST(Dgps, TooFewSatellitesAreUnusableAndAnUnknownNumberIsNot) {
  auto bench = dgps(", min_satellites: 6");
  GnssFix fix = local(1.0, 2.0);
  fix.satellites = 5;
  EXPECT_THROW(bench.feed(measurement_of(fix)), DataError);
  fix.satellites = 6;
  EXPECT_NO_THROW(bench.feed(measurement_of(fix)));
  fix.satellites = -1;
  EXPECT_NO_THROW(bench.feed(measurement_of(fix)));
}

TEST(Dgps, AFixWithoutAnyPositionIsUnusable) {
  auto bench = dgps("");
  EXPECT_THROW(bench.feed(measurement_of(GnssFix{})), DataError);
}

TEST(Dgps, ALatitudeBeyondThePoleIsUnusable) {
  auto bench = dgps("");
  bench.datum = Datum{49.0, 8.0, 0.0};
  EXPECT_THROW(bench.feed(measurement_of(geodetic(490157.0, 8.0))), DataError);
}

// --- start
// -------------------------------------------------------------------------------------------------------------

TEST(Dgps, TheStartHintSaysWhereTheAntennaIs) {
  const auto hint =
      dgps(", offset_sigma_m: 0.4").sensor().start_hint(measurement_of(local(3.0, 4.0, GnssFix::kUnknown)), nullptr);
  ASSERT_TRUE(hint && hint->p_map_point);
  EXPECT_EQ(*hint->p_map_point, Eigen::Vector3d(3.0, 4.0, 0.0));
  EXPECT_EQ(hint->p_base_point, Eigen::Vector3d(0.5, -0.2, 1.1));
  EXPECT_NEAR(hint->sigma_m, 0.5, kExact);  // white part and offset
  EXPECT_FALSE(hint->yaw_rad);
  EXPECT_FALSE(hint->datum);
}

TEST(Dgps, TheFirstGeodeticFixProposesTheDatum) {
  const auto hint = dgps("").sensor().start_hint(measurement_of(geodetic(49.0, 8.0, 115.0)), nullptr);
  ASSERT_TRUE(hint && hint->datum);
  EXPECT_EQ(hint->datum->latitude_deg, 49.0);
  EXPECT_EQ(hint->datum->longitude_deg, 8.0);
  EXPECT_EQ(hint->datum->height_m, 115.0);
}

TEST(Dgps, WithADatumAGeodeticFixIsAPlace) {
  const Datum datum{49.0, 8.0, 115.0};
  const auto hint = dgps("").sensor().start_hint(measurement_of(geodetic(49.001, 8.0, 115.0)), &datum);
  ASSERT_TRUE(hint && hint->p_map_point);
  EXPECT_NEAR(hint->p_map_point->y(), (meridian_radius(49.0) + 115.0) * 0.001 * kDegree, 1e-3);
}

TEST(Dgps, IsAbsoluteAndNoMotionSource) {
  const auto bench = dgps("");
  EXPECT_TRUE(bench.sensor().traits().is_absolute);
  EXPECT_FALSE(bench.sensor().traits().is_motion_source);
}

// --- implausible ----------------------------------------------------------------------------------------------------

/// Feeds a fix; why it was rejected, or nothing if it gave its update.
std::string rejection(Sensor& sensor, const StateLayout& layout, const NavState& mean, const GnssFix& fix, double t) {
  Belief belief;
  belief.mean = mean;
  belief.P = 0.01 * ErrorMatrix::Identity(layout.size(), layout.size());
  UpdateList updates;
  sensor.process(measurement_of(fix, t), {belief, layout, mean.block.data(), nullptr, false}, updates);
  EXPECT_EQ(updates.size() == 0, !updates.degraded_reason().empty());
  return std::string(updates.degraded_reason());
}

TEST(DgpsDoubts, AJumpIsSaidAndGivesNoUpdate) {
  const auto sensor = make_sensor("dgps", "{ base_p_antenna_m: none, sigma_m: 0.3 }");
  const StateLayout layout(StateLayout::Motion::planar, {{"gps", {}}});
  EXPECT_EQ(rejection(*sensor, layout, {}, local(0.1, 0.0), 1.0), "");
  EXPECT_THAT(rejection(*sensor, layout, {}, local(30.0, 0.0), 2.0), HasSubstr("jumps"));
  EXPECT_EQ(rejection(*sensor, layout, {}, local(0.1, 0.2), 3.0), "");
}

TEST(DgpsDoubts, WhereTheMapHasAPlaceOnTheEarthTheFixIsLookedForThere) {
  const auto sensor = make_sensor("dgps", "{ base_p_antenna_m: none, sigma_m: 0.3 }");
  const StateLayout layout(StateLayout::Motion::planar,
                           {{"gps", {}},
                            {std::string(estimation::Georeference::kOwner),
                             estimation::Georeference::block(StateLayout::Motion::planar, {.enabled = true})}});
  NavState mean;
  mean.T_map_base = Pose::planar(100.0, 60.0, 0.5 * std::numbers::pi);  // in ENU, as the mixture is
  mean.block.setZero(layout.block_size());
  mean.block << 100.0, 50.0, 0.5 * std::numbers::pi;  // x, y, yaw of the map: there the robot is at (10, 0)
  EXPECT_EQ(rejection(*sensor, layout, mean, local(100.0, 60.0), 1.0), "");
  EXPECT_EQ(rejection(*sensor, layout, mean, local(100.2, 59.9), 2.0), "");
  EXPECT_THAT(rejection(*sensor, layout, mean, local(10.0, 0.0), 3.0), HasSubstr("jumps"));
}

TEST(DgpsDoubts, SettlingIsSaidWhileTheFixIsUsed) {
  auto bench = dgps("");
  GnssFix fix = local(0.5, -0.2);
  fix.type = GnssFix::Type::rtk_fixed;
  EXPECT_NEAR(bench.feed(measurement_of(fix, 1.0)).R(0, 0), 0.09, kExact);
  fix.type = GnssFix::Type::single;
  EXPECT_NEAR(bench.feed(measurement_of(fix, 2.0)).R(0, 0), 9.0 * 0.09, kExact);
}

TEST(DgpsDoubts, FewSatellitesCountAsWorse) {
  GnssFix fix = local(1.0, 2.0);
  fix.satellites = 4;
  EXPECT_NEAR(sigma_of(", good_satellites: 8", fix), 0.6, kExact);
  fix.satellites = 9;
  EXPECT_NEAR(sigma_of(", good_satellites: 8", fix), 0.3, kExact);
  fix.satellites = -1;
  EXPECT_NEAR(sigma_of(", good_satellites: 8", fix), 0.3, kExact);
}

// --- refusals
// ----------------------------------------------------------------------------------------------------------

TEST(Dgps, RefusesAnOffsetOfTheHeightAlone) {
  EXPECT_THAT(
      refusal("dgps", "{ base_p_antenna_m: none, sigma_m: 0.3, offset_sigma_m: 0, offset_vertical_sigma_m: 1 }"),
      HasSubstr("needs offset_sigma_m"));
}

TEST(Dgps, RefusesAMissingLeverArm) { EXPECT_THAT(refusal("dgps", "{ sigma_m: 0.3 }"), HasSubstr("base_p_antenna_m")); }

TEST(Dgps, TakesNoneForALeverArmThatDoesNotMatter) {
  SensorBench bench(make_sensor("dgps", "{ base_p_antenna_m: none, sigma_m: 0.3 }"));
  bench.mean.T_map_base = Pose::planar(1.0, 2.0, 0.7);
  EXPECT_NEAR(bench.feed(measurement_of(local(1.0, 2.0))).residual.norm(), 0.0, kExact);
}

TEST(Dgps, RefusesAnotherWordForTheLeverArm) {
  EXPECT_THAT(refusal("dgps", "{ base_p_antenna_m: nowhere, sigma_m: 0.3 }"), HasSubstr("none"));
}

TEST(Dgps, RefusesALeverArmOfTwoNumbers) {
  EXPECT_THAT(refusal("dgps", "{ base_p_antenna_m: [1, 2], sigma_m: 0.3 }"), HasSubstr("base_p_antenna_m"));
}

TEST(Dgps, RefusesZeroOrNegativeNoise) {
  EXPECT_THAT(refusal("dgps", "{ base_p_antenna_m: none, sigma_m: 0 }"), HasSubstr("sigma_m"));
  EXPECT_THAT(refusal("dgps", "{ base_p_antenna_m: none, sigma_m: -0.3 }"), HasSubstr("sigma_m"));
  EXPECT_THAT(refusal("dgps", "{ base_p_antenna_m: none, sigma_m: 0.3, sigma_by_type_m: { single: 0 } }"),
              HasSubstr("single"));
}

TEST(Dgps, RefusesAnUnknownFixType) {
  EXPECT_THAT(refusal("dgps", "{ base_p_antenna_m: none, sigma_m: 0.3, sigma_by_type_m: { rtk: 1 } }"),
              HasSubstr("rtk"));
}

}  // namespace
}  // namespace waymark
