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

/// Offsets of a standing antenna, one per fix, without white noise.
struct Recording {
  std::vector<GnssFix> fixes;
  std::vector<Eigen::Vector3d> offsets;
};

Recording record(const std::string& gps, const std::string& duration_s) {
  const auto source =
      make(kShortDrive + ", duration_s: " + duration_s + ", gps: { sensor: gps, rate_hz: 2, " + gps + " } }");
  const Eigen::Vector3d truth = source->reference()->trajectory.back().T_map_base.p;
  Recording recording;
  for (const Measurement& m : read_all(*source)) {
    if (m.stamp < Time{from_seconds(10.0)}) continue;
    recording.fixes.push_back(m.as<GnssFix>());
    recording.offsets.push_back(m.as<GnssFix>().p_map_antenna - truth);
  }
  return recording;
}

TEST(SimulatorSatellites, TheOffsetIsConstantAndJumpsAsOftenAndAsFarAsAsked) {
  const Recording recording = record("sigma_m: 1e-6, satellite_change_mean_s: 20, jump_sigma_m: 0.5", "30000");
  int jumps = 0;
  double squares[2] = {0.0, 0.0};  // of offsets with and without corrections
  int counts[2] = {0, 0};
  for (std::size_t i = 1; i < recording.offsets.size(); ++i) {
    const Eigen::Vector3d step = recording.offsets[i] - recording.offsets[i - 1];
    if (step.norm() < 1e-4) {
      ASSERT_EQ(recording.fixes[i].satellites, recording.fixes[i - 1].satellites);
      continue;
    }
    ++jumps;
    const int kind = recording.fixes[i].type == GnssFix::Type::single ? 1 : 0;
    squares[kind] += recording.offsets[i].head<2>().squaredNorm();
    counts[kind] += 2;
  }
  // Of the times between fixes (0.5 s), a share of 1 - exp(-0.5/20) holds a change: 1480 are expected.
  const double expected = static_cast<double>(recording.offsets.size()) * -std::expm1(-0.5 / 20.0);
  EXPECT_NEAR(jumps, expected, 4.0 * std::sqrt(expected));
  for (int kind = 0; kind < 2; ++kind) {
    ASSERT_GT(counts[kind], 200);
    const double variance = kind == 0 ? 0.25 : 9.0 * 0.25;
    EXPECT_NEAR(squares[kind] / counts[kind], variance, 4.0 * variance * std::sqrt(2.0 / counts[kind]));
  }
}

TEST(SimulatorSatellites, QualityGoesWithTheSatellites) {
  const Recording recording = record("sigma_m: 0.2, satellite_change_mean_s: 5", "3000");
  double hdop_of[12] = {};
  for (const GnssFix& fix : recording.fixes) {
    ASSERT_GE(fix.satellites, 4);
    ASSERT_LE(fix.satellites, 11);
    hdop_of[fix.satellites] = fix.hdop;
    const bool few = fix.satellites < 6;
    ASSERT_EQ(fix.type, few ? GnssFix::Type::single : GnssFix::Type::differential);
    ASSERT_NEAR(fix.sigma_horizontal_m, few ? 0.6 : 0.2, 1e-12);
  }
  for (int satellites = 5; satellites <= 11; ++satellites) {
    EXPECT_LT(hdop_of[satellites], hdop_of[satellites - 1]);
    EXPECT_GT(hdop_of[satellites], 0.5);
  }
}

TEST(SimulatorSatellites, WithoutTheKeyThereAreNone) {
  for (const GnssFix& fix : record("sigma_m: 0.2", "60").fixes) {
    ASSERT_EQ(fix.satellites, -1);
    ASSERT_TRUE(std::isnan(fix.hdop));
    ASSERT_EQ(fix.type, GnssFix::Type::differential);
  }
}

TEST(SimulatorSatellites, AJumpLeavesTheOtherErrorsAlone) {
  const Recording without = record("sigma_m: 0.2, correlated_sigma_m: 0.5", "60");
  const Recording with =
      record("sigma_m: 0.2, correlated_sigma_m: 0.5, satellite_change_mean_s: 1e6, jump_sigma_m: 3", "60");
  ASSERT_EQ(with.fixes.front().type, GnssFix::Type::differential) << "another seed is needed";
  const Eigen::Vector3d jump = with.offsets.front() - without.offsets.front();
  EXPECT_GT(jump.norm(), 0.1);
  for (std::size_t i = 0; i < with.offsets.size(); ++i) {
    ASSERT_LT((with.offsets[i] - without.offsets[i] - jump).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace waymark
