// SPDX-License-Identifier: Apache-2.0
#include "waymark/interface/sensor_summary.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <utility>

namespace waymark {
namespace {

SensorReport report(double nis_per_row, std::uint64_t updates) {
  SensorReport sensor;
  sensor.name = "gps";
  sensor.measurements = sensor.fused = updates;
  sensor.last = Time{} + std::chrono::seconds(10);
  sensor.nis_count = updates;
  sensor.nis_dof = 2 * updates;
  sensor.nis_sum = nis_per_row * static_cast<double>(sensor.nis_dof);
  return sensor;
}

TEST(SensorSummary, NisNearItsExpectationIsConsistent) {
  EXPECT_EQ(summarize(report(1.0, 1000)).verdict, "consistent");
  EXPECT_EQ(summarize(report(1.5, 1000)).verdict, "consistent");  // correlated innovations do that
}

TEST(SensorSummary, LargeInnovationsAreOverconfidentAndSmallOnesConservative) {
  EXPECT_EQ(summarize(report(4.0, 1000)).verdict, "overconfident: innovations are 2 times what σ predicts");
  EXPECT_EQ(summarize(report(0.09, 1000)).verdict, "conservative: innovations are 0.3 times what σ predicts");
}

TEST(SensorSummary, SmallInnovationsOfAMotionSourceAreNoVerdict) {
  SensorReport wheels = report(0.01, 1000);
  wheels.is_motion_source = true;
  EXPECT_EQ(summarize(wheels).verdict, "small, as of every motion source");
  wheels.nis_sum *= 400.0;
  EXPECT_EQ(summarize(wheels).verdict, "overconfident: innovations are 2 times what σ predicts");
}

TEST(SensorSummary, InnovationsOfASensorForMapsJudgeTheMotion) {
  SensorReport lidar = report(9.0, 1000);
  lidar.mapped = std::exchange(lidar.fused, 0);
  EXPECT_EQ(summarize(lidar).verdict, "overconfident: poses in the map are off by 3 times what σ predicts");
  lidar.nis_sum /= 36.0;
  EXPECT_EQ(summarize(lidar).verdict, "small: the motion is no worse than σ predicts");
  lidar.nis_sum *= 4.0;
  EXPECT_EQ(summarize(lidar).verdict, "consistent");
}

TEST(SensorSummary, AFewUpdatesProveNothing) { EXPECT_EQ(summarize(report(2.5, 1)).verdict, "consistent"); }

TEST(SensorSummary, TheBandIsThatOfChiSquaredAndHasTheMeanInside) {
  const SensorSummary summary = summarize(report(1.0, 50));
  EXPECT_NEAR(summary.nis_low, 0.742, 0.001);  // 100 degrees of freedom: 74.22 and 129.56
  EXPECT_NEAR(summary.nis_high, 1.296, 0.001);
}

TEST(SensorSummary, ASensorWithoutUpdatesSaysWhy) {
  SensorReport sensor;
  EXPECT_EQ(summarize(sensor).verdict, "no measurements");
  sensor.measurements = sensor.held_out = 5;
  EXPECT_EQ(summarize(sensor).verdict, "held out");
  EXPECT_TRUE(std::isnan(summarize(sensor).nis_ratio));
}

TEST(SensorSummary, CountsWhatWasUsedAndWhatWasRejected) {
  SensorReport sensor = report(1.0, 11);
  sensor.mapped = 3;
  sensor.gated = 2;
  sensor.unusable = 1;
  const SensorSummary summary = summarize(sensor);
  EXPECT_EQ(summary.used, 14);
  EXPECT_EQ(summary.rejected, 3);
  EXPECT_DOUBLE_EQ(summary.rate_hz, 1.0);
}

}  // namespace
}  // namespace waymark
