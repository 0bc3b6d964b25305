// SPDX-License-Identifier: Apache-2.0
// Faulty receivers: gross outliers, frozen and creeping fixes; and the velocity that they report.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "simulated_log.hpp"

namespace waymark {
namespace {

using test::kLoop;
using test::kShortDrive;
using test::make;
using test::read_all;

std::vector<Measurement> record(const std::string& gps, const std::string& robot = kLoop) {
  return read_all(*make(robot + ", gps: { sensor: gps, correlated_sigma_m: 0.5" + gps + " } }"));
}

double time_of(const Measurement& m) { return to_seconds(m.stamp.time_since_epoch()); }
const Eigen::Vector3d& position(const Measurement& m) { return m.as<GnssFix>().p_map_antenna; }

TEST(SimulatorGpsFaults, OutliersAreAsManyAndAsFarAsAskedAndTheRestStays) {
  const std::string robot = kShortDrive + ", duration_s: 2000";
  const auto plain = record("", robot);
  const auto wild = record(", outlier_probability: 0.3, outlier_max_m: 200", robot);
  ASSERT_EQ(wild.size(), plain.size());
  std::vector<Eigen::Vector3d> errors;
  for (std::size_t i = 0; i < plain.size(); ++i) {
    const Eigen::Vector3d error = position(wild[i]) - position(plain[i]);
    ASSERT_EQ(wild[i].as<GnssFix>().sigma_horizontal_m, plain[i].as<GnssFix>().sigma_horizontal_m);
    if (error.isZero(0.0)) continue;
    ASSERT_LE(error.norm(), 200.0);
    ASSERT_EQ(error.z(), 0.0);
    errors.push_back(error);
  }
  const auto count = static_cast<double>(errors.size());
  EXPECT_NEAR(count, 3000.0, 4.0 * std::sqrt(0.21 * 10000.0));
  double mean = 0.0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& error : errors) {
    mean += error.norm() / count;
    sum += error;
  }
  EXPECT_NEAR(mean, 100.0, 4.0 * 200.0 / std::sqrt(12.0 * count));
  EXPECT_LT(sum.norm() / count, 4.0 * 200.0 / std::sqrt(3.0 * count)) << "some direction is preferred";
}

TEST(SimulatorGpsFaults, AFrozenReceiverRepeatsItsLastFix) {
  const auto plain = record(", speed_sigma_mps: 0.1");
  const auto frozen = record(", speed_sigma_mps: 0.1, frozen_s: [10, 15]");
  ASSERT_EQ(frozen.size(), plain.size());
  const Measurement* last = nullptr;
  int repeated = 0;
  for (std::size_t i = 0; i < plain.size(); ++i) {
    ASSERT_EQ(frozen[i].stamp, plain[i].stamp);
    if (time_of(frozen[i]) < 10.0) last = &frozen[i];
    const bool stuck = time_of(frozen[i]) >= 10.0 && time_of(frozen[i]) < 15.0;
    repeated += stuck ? 1 : 0;
    const Measurement& expected = stuck ? *last : plain[i];
    ASSERT_EQ(position(frozen[i]), position(expected)) << time_of(frozen[i]);
    ASSERT_EQ(frozen[i].as<GnssFix>().speed_mps, expected.as<GnssFix>().speed_mps);
    ASSERT_EQ(frozen[i].as<GnssFix>().course_rad, expected.as<GnssFix>().course_rad);
  }
  EXPECT_EQ(repeated, 25);
}

TEST(SimulatorGpsFaults, AReceiverFrozenFromTheStartRepeatsItsFirstFix) {
  const auto plain = record("");
  const auto frozen = record(", frozen_s: [0, 2]");
  for (std::size_t i = 0; i < 10; ++i) ASSERT_EQ(position(frozen[i]), position(plain.front()));
  EXPECT_EQ(position(frozen[10]), position(plain[10]));
}

TEST(SimulatorGpsFaults, ADriftingFixCreepsAwayAndComesBack) {
  const auto plain = record("");
  const auto creeping = record(", drift_s: [10, 20, 30, 40], drift_mps: 0.2");
  std::vector<Eigen::Vector3d> ends;
  for (std::size_t i = 0; i < plain.size(); ++i) {
    const double t = time_of(plain[i]);
    const double begin = t >= 10.0 && t < 20.0 ? 10.0 : t >= 30.0 && t < 40.0 ? 30.0 : t;
    const Eigen::Vector3d error = position(creeping[i]) - position(plain[i]);
    ASSERT_NEAR(error.norm(), 0.2 * (t - begin), 1e-9) << t;
    if (begin < t && t > begin + 9.8) ends.push_back(error);
  }
  ASSERT_EQ(ends.size(), 2u);
  EXPECT_GT((ends[0] - ends[1]).norm(), 0.1) << "both spans drift into one direction";
}

TEST(SimulatorGpsFaults, WithoutTheKeyThereIsNoVelocity) {
  for (const Measurement& m : record("")) {
    ASSERT_TRUE(std::isnan(m.as<GnssFix>().speed_mps));
    ASSERT_TRUE(std::isnan(m.as<GnssFix>().course_rad));
  }
}

TEST(SimulatorGpsFaults, SpeedAndCourseAreThoseOfTheAntenna) {
  // Without noise worth speaking of: speed and course against differences of noiseless positions.
  const std::string exact =
      "{ duration_s: 60, course: { waypoints_m: [0, 0, 12, 0, 12, 8, 0, 8] }, gps: { sensor: gps, rate_hz: 100, "
      "sigma_m: "
      "1e-9, base_p_antenna_m: [0.5, 0.3, 1], speed_sigma_mps: 1e-9 } }";
  const auto fixes = read_all(*make(exact));
  int turning = 0;
  for (std::size_t i = 1; i + 1 < fixes.size(); ++i) {
    const Eigen::Vector2d v = (position(fixes[i + 1]) - position(fixes[i - 1])).head<2>() / 0.02;
    const auto& fix = fixes[i].as<GnssFix>();
    ASSERT_NEAR(fix.speed_mps, v.norm(), 0.02) << time_of(fixes[i]);
    if (v.norm() < 0.2) continue;
    ASSERT_NEAR(so3::wrap(fix.course_rad - std::atan2(v.x(), v.y())), 0.0, 0.05) << time_of(fixes[i]);
    turning += std::abs(so3::wrap(fix.course_rad - fixes[i - 1].as<GnssFix>().course_rad)) > 0.003 ? 1 : 0;
  }
  EXPECT_GT(turning, 100);
}

TEST(SimulatorGpsFaults, TheVelocityIsAsNoisyAsAskedAndLeavesThePositionAlone) {
  const std::string robot = kShortDrive + ", duration_s: 1000";
  const auto plain = record("", robot);
  const auto fast = record(", speed_sigma_mps: 0.2", robot);
  double squares = 0.0;
  int standing = 0;
  for (std::size_t i = 0; i < plain.size(); ++i) {
    ASSERT_EQ(position(fast[i]), position(plain[i]));
    if (time_of(fast[i]) < 5.0) continue;
    squares += std::pow(fast[i].as<GnssFix>().speed_mps, 2);
    ++standing;
  }
  // Of two components: the mean square is 2 σ².
  EXPECT_NEAR(squares / standing / (2.0 * 0.04), 1.0, 4.0 / std::sqrt(static_cast<double>(standing)));
}

}  // namespace
}  // namespace waymark
