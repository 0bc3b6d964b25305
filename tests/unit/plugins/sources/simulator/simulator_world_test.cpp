// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "simulated_log.hpp"

namespace waymark {
namespace {

using test::kLoop;
using test::kShortDrive;
using test::kWheels;
using test::make;
using test::read_all;

const std::string kExactLidar =
    ", lidar: { sensor: lidar, sigma_m: 1e-9, start_deg: -180, step_deg: 0.5, beams: 720, range_max_m: 20 } }";

/// The last scan of a robot that stands at (1, 0) and looks east; 21: no return.
std::vector<float> scan_of(const std::string& world, double scanner_height_m = 0.2) {
  const Pose T_base_lidar{Eigen::Quaterniond::Identity(), {0.0, 0.0, scanner_height_m}};
  const auto source = make(kShortDrive + ", duration_s: 6" + world + kExactLidar, T_base_lidar);
  return read_all(*source).back().as<LaserScan>().ranges_m;
}

int returns_in(const std::vector<float>& ranges) {
  return static_cast<int>(std::ranges::count_if(ranges, [](float range) { return range <= 20.0f; }));
}

const std::string kClutterArea = "area_m: [-8, -8, 10, 8], seed: 5";

TEST(SimulatorWorld, AWallIsSeenFromBothSidesUpToItsEnds) {
  const auto east = scan_of(", walls_m: [6, -5, 6, 5]");
  const auto reversed = scan_of(", walls_m: [6, 5, 6, -5]");
  for (int beam = 0; beam < 720; ++beam) {
    const double angle = (beam * 0.5 - 180.0) * std::numbers::pi / 180.0;
    const bool meets = std::cos(angle) > 0.0 && std::abs(5.0 * std::tan(angle)) < 5.0;
    if (std::abs(std::abs(angle) - std::numbers::pi / 4.0) < 0.01) continue;  // exactly at an end
    // The robot stands within a millimetre of x = 1.
    ASSERT_NEAR(east[static_cast<std::size_t>(beam)], meets ? 5.0 / std::cos(angle) : 21.0, 2e-3) << "beam " << beam;
    ASSERT_EQ(east[static_cast<std::size_t>(beam)], reversed[static_cast<std::size_t>(beam)]);
  }
}

TEST(SimulatorWorld, AScannerSeesOnlyWhatIsHigherThanItself) {
  const std::string stones = ", clutter: { stones: 12, stone_height_m: [0.3, 0.5], " + kClutterArea + " }";
  const std::string boxes = ", clutter: { boxes: 12, box_height_m: [0.3, 0.5], " + kClutterArea + " }";
  const std::string corners = ", wall_height_m: 0.5, clutter: { corners: 12, " + kClutterArea + " }";
  const std::string landmarks = ", landmarks: { list_m: [5, 0, 0.5, 1, 5, 0.5], height_m: [0.4, 0.5] }";
  for (const std::string& world : {stones, boxes, corners, landmarks}) {
    EXPECT_GT(returns_in(scan_of(world, 0.25)), 10) << world;
    EXPECT_EQ(returns_in(scan_of(world, 0.55)), 0) << world;
  }
}

TEST(SimulatorWorld, ABoxHasFlatSidesAndRightAngles) {
  const auto ranges = scan_of(", clutter: { boxes: 1, box_size_m: [3, 3], area_m: [4.9, -0.1, 5.1, 0.1], seed: 3 }");
  std::vector<Eigen::Vector2d> outline;
  for (std::size_t beam = 0; beam < ranges.size(); ++beam) {
    if (ranges[beam] > 20.0f) continue;
    const double angle = (static_cast<double>(beam) * 0.5 - 180.0) * std::numbers::pi / 180.0;
    outline.push_back(static_cast<double>(ranges[beam]) * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  ASSERT_GT(outline.size(), 40u);
  // Neighbouring points turn at most once, at the corner, and there by a right angle.
  int corners = 0;
  for (std::size_t i = 2; i + 2 < outline.size(); ++i) {
    const Eigen::Vector2d before = (outline[i - 1] - outline[i - 2]).normalized();
    const Eigen::Vector2d after = (outline[i + 2] - outline[i + 1]).normalized();
    const double turn = std::acos(std::clamp(before.dot(after), -1.0, 1.0));
    if (turn < 0.01) continue;
    ASSERT_NEAR(turn, std::numbers::pi / 2.0, 0.01);
    ++corners;
  }
  EXPECT_LE(corners, 3);  // one corner is met by up to three such pairs
}

TEST(SimulatorWorld, OnlyCylindersAreLandmarks) {
  const auto plain = make(kLoop + kWheels + "}");
  const auto full = make(kLoop + ", walls_m: [-9, -9, 20, -9]" +
                         ", clutter: { stones: 4, boxes: 4, corners: 2, area_m: [-8, -8, 20, 16] }" + kWheels + "}");
  ASSERT_EQ(full->reference()->landmarks.size(), plain->reference()->landmarks.size());
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_EQ(full->reference()->landmarks[i].p_map, plain->reference()->landmarks[i].p_map);
    EXPECT_EQ(full->reference()->landmarks[i].name, "c" + std::to_string(i + 1));
  }
}

TEST(SimulatorWorld, TexturesMoveNoLandmarkAndTheNameTellsTheClass) {
  const std::string loop =
      "{ duration_s: 5, course: { waypoints_m: [0, 0, 12, 0, 12, 8, 0, 8] },"
      "  landmarks: { count: 30, area_m: [-9, -9, 21, 17], seed: 7";
  const auto plain = make(loop + " }" + kWheels + "}");
  const auto dressed = make(loop + ", textures: 3, height_m: [1, 4] }" + kWheels + "}");
  std::set<std::string> classes;
  for (std::size_t i = 0; i < 30; ++i) {
    const auto& landmark = dressed->reference()->landmarks[i];
    EXPECT_EQ(landmark.p_map, plain->reference()->landmarks[i].p_map);
    EXPECT_EQ(landmark.radius_m, plain->reference()->landmarks[i].radius_m);
    EXPECT_EQ(landmark.name.find("c" + std::to_string(i + 1) + "_t"), 0u) << landmark.name;
    classes.insert(landmark.name.substr(landmark.name.find('_')));
  }
  EXPECT_EQ(classes, (std::set<std::string>{"_t0", "_t1", "_t2"}));
  const auto listed = make(
      "{ duration_s: 5, course: { waypoints_m: [0, 0, 5, 0] },"
      "  landmarks: { list_m: [2, 9, 0.2, 4, 9, 0.2], textures: 5, list_texture: [4, 1] }" +
      kWheels + "}");
  EXPECT_EQ(listed->reference()->landmarks[0].name, "c1_t4");
  EXPECT_EQ(listed->reference()->landmarks[1].name, "c2_t1");
}

}  // namespace
}  // namespace waymark
