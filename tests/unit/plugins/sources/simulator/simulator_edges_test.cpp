// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "simulated_log.hpp"

namespace waymark {
namespace {

using test::kShortDrive;
using test::make;
using test::read_all;

/// A pillar of radius 0.5 m at 5 m in front of a wall at 9 m, seen by a robot that stands at (1, 0).
std::vector<std::vector<float>> scans_of(const std::string& lidar) {
  const auto source = make(kShortDrive +
                           ", duration_s: 60, landmarks: { list_m: [6, 0, 0.5] }, walls_m: [10, -9, 10, 9],"
                           "  lidar: { sensor: lidar, start_deg: -20, step_deg: 0.25, beams: 161, sigma_m: 1e-9, " +
                           lidar + " } }");
  std::vector<std::vector<float>> scans;
  for (const Measurement& m : read_all(*source)) {
    if (m.stamp >= Time{from_seconds(5.0)}) scans.push_back(m.as<LaserScan>().ranges_m);
  }
  return scans;
}

double angle_of(std::size_t beam) { return (-20.0 + 0.25 * static_cast<double>(beam)) * std::numbers::pi / 180.0; }

TEST(SimulatorEdges, MixedPixelsLieBetweenForeAndBackgroundAndOnlyAtEdges) {
  const double half_width = 0.5 * std::numbers::pi / 180.0;
  int mixed = 0;
  int at_an_edge = 0;
  for (const auto& scan : scans_of("beam_width_deg: 1, mixed_probability: 0.3, edge_m: 0.6")) {
    for (std::size_t beam = 0; beam < scan.size(); ++beam) {
      const double edge = std::asin(0.5 / 5.0);
      const double to_edge = std::abs(std::abs(angle_of(beam)) - edge);
      const bool between = scan[beam] > 5.6f && scan[beam] < 8.9f;
      const bool split = to_edge < 0.7 * half_width;
      if (between) {
        ASSERT_LT(to_edge, half_width) << "beam " << beam;
      }
      mixed += between && split ? 1 : 0;
      at_an_edge += split ? 1 : 0;
    }
  }
  ASSERT_GT(at_an_edge, 500);
  // A mixed pixel is uniform between both surfaces (5.0 and 9.1 m); of those, 0.8 lie in what counts as between.
  EXPECT_NEAR(static_cast<double>(mixed) / at_an_edge, 0.3 * 0.8, 0.05);
}

TEST(SimulatorEdges, AWideBeamSeesThePillarWider) {
  const auto width_of = [](const std::string& lidar) {
    const auto scan = scans_of(lidar).front();
    return std::ranges::count_if(scan, [](float range) { return range < 6.0f; });
  };
  const auto thin = width_of("beam_width_deg: 0");
  EXPECT_NEAR(static_cast<double>(thin), 2.0 * std::asin(0.1) * 180.0 / std::numbers::pi / 0.25, 1.0);
  // Sub-rays reach 3/7 of the width to each side.
  EXPECT_NEAR(static_cast<double>(width_of("beam_width_deg: 1, mixed_probability: 0") - thin), 0.857 / 0.25, 1.5);
}

TEST(SimulatorEdges, AwayFromEdgesABeamWithWidthMeasuresTheSame) {
  const auto thin = scans_of("beam_width_deg: 0").front();
  const auto wide = scans_of("beam_width_deg: 1").front();
  for (std::size_t beam = 0; beam < thin.size(); ++beam) {
    if (std::abs(std::abs(angle_of(beam)) - std::asin(0.1)) < 0.6 * std::numbers::pi / 180.0) continue;
    ASSERT_NEAR(wide[beam], thin[beam], 0.02) << "beam " << beam;
  }
}

}  // namespace
}  // namespace waymark
