// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "simulated_log.hpp"

namespace waymark {
namespace {

using test::kShortDrive;
using test::make;
using test::read_all;

const std::string kPlaces = "places_m: [21, 0, 0,  1, 30, 0,  1, 0, 12]";
constexpr double kDistances[3] = {20.0, 30.0, 12.0};  // from where the robot stands

/// The bursts that a standing robot gets.
std::vector<Ranges> record(const std::string& beacons, const std::string& duration_s = "1000") {
  const auto source = make(kShortDrive + ", duration_s: " + duration_s + ", beacons: { sensor: wheels, " + kPlaces +
                           ", " + beacons + " } }");
  std::vector<Ranges> bursts;
  for (const Measurement& m : read_all(*source)) {
    if (m.stamp > Time{from_seconds(10.0)}) bursts.push_back(m.as<Ranges>());
  }
  return bursts;
}

TEST(SimulatorBeacons, ARangeIsScaleTimesDistanceAndOffsetAndWhiteNoise) {
  std::vector<double> errors;
  for (const Ranges& burst : record("sigma_m: 0.2, scale: 1.07, offset_m: 0.3")) {
    ASSERT_EQ(burst.ranges.size(), 3u);
    for (const Ranges::One& one : burst.ranges) {
      ASSERT_EQ(one.reference, -1);
      ASSERT_DOUBLE_EQ(one.sigma_m, 0.2);
      errors.push_back(one.range_m - 1.07 * kDistances[one.beacon] - 0.3);
    }
  }
  double sum = 0.0;
  double squares = 0.0;
  for (const double error : errors) {
    sum += error;
    squares += error * error;
  }
  const auto n = static_cast<double>(errors.size());
  EXPECT_GT(n, 10000.0);
  EXPECT_NEAR(sum / n, 0.0, 4.0 * 0.2 / std::sqrt(n));
  EXPECT_NEAR(squares / n, 0.04, 4.0 * 0.04 * std::sqrt(2.0 / n));
}

TEST(SimulatorBeacons, LatePathsAreLongerByAnExponentialExcess) {
  int late = 0;
  int all = 0;
  double excess = 0.0;
  for (const Ranges& burst : record("sigma_m: 1.0e-6, late_share: 0.2, late_excess_m: 1.5")) {
    for (const Ranges::One& one : burst.ranges) {
      const double error = one.range_m - kDistances[one.beacon];
      ASSERT_GT(error, -1e-2);
      ++all;
      if (error < 1e-2) continue;
      ++late;
      excess += error;
    }
  }
  EXPECT_NEAR(late, 0.2 * all, 4.0 * std::sqrt(0.16 * all));
  EXPECT_NEAR(excess / late, 1.5, 4.0 * 1.5 / std::sqrt(late));
}

TEST(SimulatorBeacons, InTurnEachMeasurementHasTheNextBeacon) {
  int expected = -1;
  for (const Ranges& burst : record("in_turn: true", "30")) {
    ASSERT_EQ(burst.ranges.size(), 1u);
    if (expected >= 0) {
      ASSERT_EQ(burst.ranges.front().beacon, expected);
    }
    expected = (burst.ranges.front().beacon + 1) % 3;
  }
  EXPECT_GE(expected, 0);
}

TEST(SimulatorBeacons, DifferencesHaveTheRangeToTheFirstBeaconInCommon) {
  for (const Ranges& burst : record("sigma_m: 1.0e-6, differences: true", "30")) {
    ASSERT_EQ(burst.ranges.size(), 2u);
    for (const Ranges::One& one : burst.ranges) {
      ASSERT_EQ(one.reference, 0);
      ASSERT_NEAR(one.range_m, kDistances[one.beacon] - kDistances[0], 1e-2);
    }
  }
}

TEST(SimulatorBeacons, ABeaconThatIsTooFarAwayIsNotHeard) {
  for (const Ranges& burst : record("range_max_m: 25", "30")) {
    for (const Ranges::One& one : burst.ranges) ASSERT_NE(one.beacon, 1);
  }
  EXPECT_TRUE(record("range_max_m: 5", "30").empty());
}

TEST(SimulatorBeacons, PlacesThatAreNoTriplesAreRefused) {
  EXPECT_THROW(make(kShortDrive + ", duration_s: 1, beacons: { sensor: wheels, places_m: [1, 2] } }"), ConfigError);
}

}  // namespace
}  // namespace waymark
