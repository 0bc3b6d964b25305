// SPDX-License-Identifier: Apache-2.0
// needs plugins: simulator
#include "apps/waymark/evaluation/surfaces.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <numbers>
#include <string>

#include "temporary_folder.hpp"
#include "waymark/base/error.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/interface/source.hpp"
#include "waymark/plugin_loader.hpp"

namespace waymark::evaluation {
namespace {

using ::testing::HasSubstr;

const Surface kPillar{Surface::Kind::cylinder, {1.0, 2.0}, {1.0, 2.0}, 0.5, 3.0};
const Surface kBlock{Surface::Kind::box, {0.0, 1.0}, {4.0, 1.0}, 0.5, 2.0};
const Surface kWall{Surface::Kind::box, {0.0, 0.0}, {3.0, 4.0}, 0.0, 2.0};
const Surface kCeiling{Surface::Kind::level, {0.0, 0.0}, {0.0, 0.0}, 0.0, 2.5};

TEST(Surfaces, DistancesAreThoseOfTheirShapes) {
  EXPECT_NEAR(distance(kPillar, {3.0, 2.0, 1.0}), 1.5, 1e-12);
  EXPECT_NEAR(distance(kPillar, {1.0, 2.3, 1.0}), 0.2, 1e-12);              // from inside to the side
  EXPECT_NEAR(distance(kPillar, {1.0, 2.0, 2.9}), 0.1, 1e-12);              // from inside to the top
  EXPECT_NEAR(distance(kPillar, {1.0, 2.0, 4.0}), 1.0, 1e-12);              // above it
  EXPECT_NEAR(distance(kPillar, {1.0 + 0.5 + 0.3, 2.0, 3.4}), 0.5, 1e-12);  // over the edge
  EXPECT_NEAR(distance(kPillar, {1.8, 2.0, -0.4}), 0.5, 1e-12);             // under the ground
  EXPECT_NEAR(distance(kBlock, {2.0, 2.0, 1.0}), 0.5, 1e-12);
  EXPECT_NEAR(distance(kBlock, {2.0, 1.1, 1.0}), 0.4, 1e-12);
  EXPECT_NEAR(distance(kBlock, {4.3, 1.9, 1.0}), 0.5, 1e-12);             // beside a corner
  EXPECT_NEAR(distance(kWall, {1.5 - 0.8, 2.0 + 0.6, 1.0}), 1.0, 1e-12);  // from its left
  EXPECT_NEAR(distance(kWall, {1.5 + 0.8, 2.0 - 0.6, 1.0}), 1.0, 1e-12);
  EXPECT_NEAR(distance(kWall, {1.5, 2.0, 1.0}), 0.0, 1e-12);
  EXPECT_NEAR(distance(kWall, {3.6, 4.8, 1.0}), 1.0, 1e-12);
  EXPECT_NEAR(distance(kCeiling, {9.0, 9.0, 2.0}), 0.5, 1e-12);
}

TEST(Surfaces, RampsAndFloorsHaveABase) {
  const Surface ramp{Surface::Kind::ramp, {0.0, 0.0}, {4.0, 0.0}, 1.0, 1.0, 0.5, 4.0};  // slope 3/4
  EXPECT_NEAR(distance(ramp, {2.0, 0.0, 2.5 + 1.25}), 1.0, 1e-12);
  EXPECT_NEAR(distance(ramp, {2.0, 0.9, 1.0}), 0.1, 1e-12);
  EXPECT_NEAR(distance(ramp, {2.0, 1.5, 0.8}), 0.5, 1e-12);
  EXPECT_NEAR(distance(ramp, {2.0, 0.0, 0.2}), 0.3, 1e-12);
  const Surface floor{Surface::Kind::floor, {0.0, 0.0}, {4.0, 0.0}, 2.0, 2.0, 1.8, 2.0};
  EXPECT_NEAR(distance(floor, {2.0, 0.0, 2.3}), 0.3, 1e-12);
  EXPECT_NEAR(distance(floor, {2.0, 0.0, 1.4}), 0.4, 1e-12);
  EXPECT_NEAR(distance(floor, {2.0, 0.0, 1.85}), 0.05, 1e-12);
  const Region region{{-1.0, -3.0, 0.0}, {6.0, 3.0, 5.0}};
  for (const Surface& surface : {ramp, floor}) {
    int points = 0;
    for_points_on(surface, region, 0.1, [&](const Eigen::Vector3d& p) {
      ASSERT_NEAR(distance(surface, p), 0.0, 1e-9);
      ++points;
    });
    // The ramp's top seen from above, and both sides; the floor's two sides and its edge.
    const double area = surface.kind == Surface::Kind::ramp ? 4.0 * 2.0 + 2.0 * 4.0 * 2.0 : 2.0 * 16.0 + 16.0 * 0.2;
    EXPECT_NEAR(points * 0.01, area, 0.06 * area);
  }
}

TEST(Surfaces, PointsLieOnThemAndCoverThem) {
  const Region region{{-1.0, -1.0, 0.0}, {6.0, 6.0, 4.0}};
  const double spacing = 0.1;
  for (const Surface& surface : {kPillar, kBlock, kWall, kCeiling}) {
    std::vector<Eigen::Vector3d> points;
    for_points_on(surface, region, spacing, [&](const Eigen::Vector3d& p) {
      ASSERT_NEAR(distance(surface, p), 0.0, 1e-9);
      points.push_back(p);
    });
    const double pillar = std::numbers::pi * (2.0 * 0.5 * 3.0 + 0.25);
    const double block = 2.0 * (4.0 + 1.0) * 2.0 + 4.0 * 1.0;
    const double area = surface.kind == Surface::Kind::cylinder ? pillar
                        : surface.kind == Surface::Kind::level  ? 49.0
                        : surface.half_width_m > 0.0            ? block
                                                                : 10.0;
    EXPECT_NEAR(static_cast<double>(points.size()) * spacing * spacing, area, 0.03 * area);
  }
  int above = 0;
  for_points_on(kCeiling, {{0.0, 0.0, 0.0}, {1.0, 1.0, 2.5}}, spacing, [&](const Eigen::Vector3d&) { ++above; });
  EXPECT_EQ(above, 0) << "outside of the region";
}

class SurfacesFile : public ::testing::Test {
 protected:
  std::string message(const std::string& content) const {
    std::ofstream(file_) << content;
    try {
      read_surfaces(file_);
    } catch (const DataError& error) {
      return error.what();
    }
    return "none";
  }

  test::TemporaryFolder folder_;
  std::filesystem::path file_ = folder_ / "surfaces.csv";
};

TEST_F(SurfacesFile, TellsWhatIsWrong) {
  const std::string header = "kind,x_m,y_m,x2_m,y2_m,half_width_m,height_m\n";
  EXPECT_EQ(message(header + "level,,,,,,0\nwall,0,0,3,4,0,2\ncylinder,1,2,,,0.5,3\n"), "none");
  const std::string uneven = "kind,x_m,y_m,x2_m,y2_m,half_width_m,height_m,base_m,height2_m\n";
  EXPECT_EQ(message(uneven + "wave,1,0,0,,,0.1,,\nground,,,,,,0,,\nramp,0,0,4,0,1,0,0,2\nfloor,4,0,8,0,2,2,1.8,\n"),
            "none");
  EXPECT_THAT(message(uneven + "floor,4,0,8,0,2,2,,\n"), HasSubstr("base_m"));
  EXPECT_THAT(message(uneven + "floor,4,0,8,0,0,2,1,\n"), HasSubstr(":2: a thing without size"));
  EXPECT_THAT(message("name,x_m,y_m\na,1,2\n"), HasSubstr(":1: the first row must be kind,x_m"));
  EXPECT_THAT(message(header + "sphere,1,2,,,0.5,3\n"), HasSubstr(":2: kind is \"sphere\""));
  EXPECT_THAT(message(header + "cylinder,1,2,,,0,3\n"), HasSubstr(":2: a thing without size"));
  EXPECT_THAT(message(header + "wall,1,2,1,2,0,3\n"), HasSubstr(":2: a thing without size"));
  EXPECT_THAT(message(header + "box,1,2,3,2,0.5,\n"), HasSubstr("height_m"));
}

// The simulator casts rays, this page measures distances: both must mean the same world.
TEST_F(SurfacesFile, WhatTheSimulatorSeesLiesOnWhatItWrites) {
  const std::string yaml =
      "{ duration_s: 10, seed: 2, course: { waypoints_m: [0, 0, 2, 0] }, ceiling_m: 3.5, wall_height_m: 2,"
      "  landmarks: { list_m: [3, 2, 0.4], height_m: [1, 1] }, walls_m: [-3, -3, 9, -3, 9, -3, 10, 7],"
      "  boxes_m: [2, -1.5, 2, 0.5, 0.6], clutter: { boxes: 4, stones: 4, corners: 2, area_m: [-4, -4, 10, 8] },"
      "  lidar_3d: { sensor: lidar, sigma_m: 1e-9, elevation_min_deg: -60, elevation_max_deg: 60, rings: 31,"
      "              beams: 90, step_deg: 4, range_max_m: 40, rate_hz: 1 }, surfaces_file: '" +
      file_.string() + "' }";
  const Pose T_base_lidar{so3::from_rpy(0.1, -0.2, 0.3), {0.1, 0.2, 0.9}};
  const Rig rig({{.name = "lidar", .payload = "", .T_base_sensor = T_base_lidar}});
  const Config config = Config::parse(yaml);
  config.permit_outside();
  const auto source = PluginLoader({WAYMARK_PLUGIN_DIR}).create<Source>("simulator", config, rig);
  EXPECT_FALSE(std::filesystem::exists(file_)) << "written by who only looked";
  const Pose T_map_lidar = source->reference()->trajectory.back().T_map_base * T_base_lidar;
  std::vector<Surface> surfaces;
  std::vector<int> points;
  while (const auto measurement = source->next()) {
    if (surfaces.empty()) surfaces = read_surfaces(file_);
    points.resize(surfaces.size());
    if (measurement->stamp < Time{from_seconds(8.0)}) continue;  // from then on the robot stands
    for (const Eigen::Vector3f& p : measurement->as<PointCloud>().points_m) {
      const auto to_point = [&](const Surface& surface) { return distance(surface, T_map_lidar * p.cast<double>()); };
      const auto nearest = std::ranges::min_element(surfaces, {}, to_point);
      ASSERT_LT(to_point(*nearest), 1e-4) << p.transpose();
      ++points[static_cast<std::size_t>(nearest - surfaces.begin())];
    }
  }
  // Landmark, stones, the given box and those drawn, the given walls and corners of two, ground, ceiling.
  ASSERT_EQ(surfaces.size(), 1u + 4u + 1u + 4u + 2u + 2u * 2u + 2u);
  for (const std::size_t i : {0u, 5u, 10u, 11u, 16u, 17u}) EXPECT_GT(points[i], 5) << i;
}

TEST_F(SurfacesFile, TheSameWhereTheGroundIsNotLevel) {
  const std::string yaml =
      "{ duration_s: 14, seed: 2, course: { waypoints_m: [0, 0, 7, 0] }, ceiling_m: 5, wall_height_m: 2,"
      "  landmarks: { list_m: [3, 3, 0.4], height_m: [1, 1] }, bumps: { height_m: 0.03, length_m: 4 },"
      "  ramps_m: [2, 0, 0, 12, 0, 2, 3], floors: [ { area_m: [12, -4, 18, 4], height_m: 2, wall_height_m: 1,"
      "                                               walls_m: [17, -3, 17, 3], boxes_m: [14, 2, 1, 1, 0.5] } ],"
      "  lidar_3d: { sensor: lidar, sigma_m: 1e-9, elevation_min_deg: -60, elevation_max_deg: 60, rings: 31,"
      "              beams: 180, step_deg: 2, range_max_m: 40, rate_hz: 1 }, surfaces_file: '" +
      file_.string() + "' }";
  const Pose T_base_lidar{so3::from_rpy(0.1, -0.2, 0.3), {0.1, 0.2, 0.9}};
  const Rig rig({{.name = "lidar", .payload = "", .T_base_sensor = T_base_lidar}});
  const Config config = Config::parse(yaml);
  config.permit_outside();
  const auto source = PluginLoader({WAYMARK_PLUGIN_DIR}).create<Source>("simulator", config, rig);
  const Pose T_map_lidar = source->reference()->trajectory.back().T_map_base * T_base_lidar;
  EXPECT_GT(T_map_lidar.p.z(), 1.7) << "half way up the ramp";
  std::vector<Surface> surfaces;
  std::vector<int> points;
  while (const auto measurement = source->next()) {
    if (surfaces.empty()) surfaces = read_surfaces(file_);
    points.resize(surfaces.size());
    if (measurement->stamp < Time{from_seconds(12.0)}) continue;
    for (const Eigen::Vector3f& p : measurement->as<PointCloud>().points_m) {
      const auto to_point = [&](const Surface& surface) { return distance(surface, T_map_lidar * p.cast<double>()); };
      const auto nearest = std::ranges::min_element(surfaces, {}, to_point);
      ASSERT_LT(to_point(*nearest), 2e-3) << p.transpose();
      ++points[static_cast<std::size_t>(nearest - surfaces.begin())];
    }
  }
  std::map<Surface::Kind, int> seen;
  for (std::size_t i = 0; i < surfaces.size(); ++i) seen[surfaces[i].kind] += points[i];
  for (const auto kind : {Surface::Kind::ground, Surface::Kind::ramp, Surface::Kind::floor, Surface::Kind::level,
                          Surface::Kind::box, Surface::Kind::cylinder})
    EXPECT_GT(seen[kind], 5) << static_cast<int>(kind);
}

}  // namespace
}  // namespace waymark::evaluation
