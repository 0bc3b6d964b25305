// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "simulated_log.hpp"

namespace waymark {
namespace {

using test::kShortDrive;
using test::make_with;
using test::read_all;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr Intrinsics kLens{640, 480, 500.0, 505.0, 322.0, 236.0, {-0.12, 0.03, 0.001, -0.0005, 0.0}};

/// A camera 1 m above the ground.
Pose mounted(double roll_deg, double pitch_deg, double yaw_deg) {
  return {so3::from_rpy(kDegree * roll_deg, kDegree * pitch_deg, kDegree * yaw_deg), {0.1, 0.05, 1.0}};
}

const std::string kSteady =
    "noise_sigma: 0, lighting: { brightness_sigma: 0, colour_sigma: 0 }, exposure: { sigma: 0 }";

std::vector<Measurement> record(const std::string& world, const std::string& camera, const Pose& T_base_camera,
                                const Intrinsics& lens = kLens) {
  const Rig rig({{.name = "camera", .payload = "", .T_base_sensor = T_base_camera, .intrinsics = lens}});
  return read_all(*make_with(rig, kShortDrive + ", " + world + ", camera: { sensor: camera, " + camera + " } }"));
}

/// What a robot that stands at (1, 0) and looks east sees.
Image view(const std::string& world, const Pose& T_base_camera, const Intrinsics& lens = kLens) {
  return record("duration_s: 4" + world, "rate_hz: 1, " + kSteady, T_base_camera, lens).back().as<Image>();
}

std::vector<int> pixel(const Image& image, int column, int row) {
  const auto at = static_cast<std::size_t>(3 * (row * image.width + column));
  return {image.data[at], image.data[at + 1], image.data[at + 2]};
}

double mean(const Image& image) {
  double sum = 0.0;
  for (const std::uint8_t value : image.data) sum += value;
  return sum / static_cast<double>(image.data.size());
}

/// Where a point of the map appears, by the model that OpenCV calibrates.
Eigen::Vector2d project(const Eigen::Vector3d& p_map, const Pose& T_map_camera) {
  const Eigen::Vector3d p = T_map_camera.inverse() * p_map;
  const double x = -p.y() / p.x();
  const double y = -p.z() / p.x();
  const auto& [k1, k2, p1, p2, k3] = kLens.distortion;
  const double r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  return {kLens.fx * (x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x)) + kLens.cx,
          kLens.fy * (y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y) + kLens.cy};
}

TEST(SimulatorCamera, ACylinderHasItsTwoEdgesWhereTheProjectionSays) {
  const Eigen::Vector2d center(6.0, 0.8);
  const double radius = 0.25;
  for (const Pose& T_base_camera : {mounted(0, 0, 0), mounted(4, -6, 8), mounted(-3, 7, -10)}) {
    const Image with = view(", landmarks: { list_m: [6, 0.8, 0.25], height_m: [9, 9] }", T_base_camera);
    const Image without = view("", T_base_camera);
    const Pose T_map_camera = Pose::planar(1.0, 0.0, 0.0) * T_base_camera;
    const Eigen::Vector2d to_center = center - T_map_camera.p.head<2>();
    const double bearing = std::atan2(to_center.y(), to_center.x());
    const double half_angle = std::asin(radius / to_center.norm());
    const double tangent = std::sqrt(to_center.squaredNorm() - radius * radius);
    for (const double height : {0.4, 0.9, 1.3, 1.7, 2.1}) {
      for (const double side : {1.0, -1.0}) {
        const double azimuth = bearing + side * half_angle;
        const Eigen::Vector2d edge =
            T_map_camera.p.head<2>() + tangent * Eigen::Vector2d(std::cos(azimuth), std::sin(azimuth));
        const Eigen::Vector2d expected = project({edge.x(), edge.y(), height}, T_map_camera);
        const int row = static_cast<int>(std::lround(expected.y()));
        ASSERT_TRUE(row >= 0 && row < 480);
        std::vector<int> columns;  // that the cylinder covers
        for (int column = 0; column < 640; ++column) {
          if (pixel(with, column, row) != pixel(without, column, row)) columns.push_back(column);
        }
        ASSERT_FALSE(columns.empty());
        // Counter-clockwise is to the left. The outermost pixel that changes is the one that the edge runs through.
        EXPECT_NEAR(side > 0.0 ? columns.front() : columns.back(), expected.x(), 1.0) << "height " << height;
      }
    }
  }
}

TEST(SimulatorCamera, TheCylinderEndsAtItsHeightAndOnTheGround) {
  const Image with = view(", landmarks: { list_m: [6, 0.1, 0.25], height_m: [1.5, 1.5] }", mounted(0, 0, 0));
  const Image without = view("", mounted(0, 0, 0));
  const Pose T_map_camera = Pose::planar(1.0, 0.0, 0.0) * mounted(0, 0, 0);
  const Eigen::Vector2d top = project({5.75, 0.1, 1.5}, T_map_camera);
  const Eigen::Vector2d foot = project({5.75, 0.1, 0.0}, T_map_camera);
  std::vector<int> rows;
  const int column = static_cast<int>(std::lround(top.x()));
  for (int row = 0; row < 480; ++row) {
    if (pixel(with, column, row) != pixel(without, column, row)) rows.push_back(row);
  }
  ASSERT_FALSE(rows.empty());
  EXPECT_NEAR(rows.front(), top.y(), 1.5);
  EXPECT_NEAR(rows.back(), foot.y(), 1.5);
}

TEST(SimulatorCamera, AStoneDoesNotReachTheHorizon) {
  const std::string stones = ", clutter: { stones: 6, area_m: [4, -2, 9, 2], stone_height_m: [0.3, 0.5], seed: 2 }";
  const Image with = view(stones, mounted(0, 0, 0));
  const Image without = view("", mounted(0, 0, 0));
  int changed = 0;
  for (int row = 0; row < 480; ++row) {
    for (int column = 0; column < 640; ++column) {
      if (pixel(with, column, row) == pixel(without, column, row)) continue;
      ASSERT_GT(row, 240);
      ++changed;
    }
  }
  EXPECT_GT(changed, 1000);
}

TEST(SimulatorCamera, ANearThingHidesAFarOne) {
  const Image near = view(", landmarks: { list_m: [5, 0, 0.4], textures: 2, list_texture: [0] }", mounted(0, 0, 0));
  const Image both =
      view(", landmarks: { list_m: [5, 0, 0.4, 12, 0, 0.4], textures: 2, list_texture: [0, 1] }", mounted(0, 0, 0));
  for (int row = 0; row < 236; ++row) ASSERT_EQ(pixel(near, 322, row), pixel(both, 322, row));
}

/// Mean colour of the front of a cylinder at (5, y), relative to its brightness.
Eigen::Vector3d tint(const Image& image, double y) {
  const Eigen::Vector2d middle = project({4.7, y, 1.0}, Pose::planar(1.0, 0.0, 0.0) * mounted(0, 0, 0));
  Eigen::Vector3d sum(0.0, 0.0, 0.0);
  for (int row = 180; row < 290; ++row) {
    for (int offset = -15; offset <= 15; ++offset) {
      const auto bgr = pixel(image, static_cast<int>(middle.x()) + offset, row);
      sum += Eigen::Vector3d(bgr[0], bgr[1], bgr[2]);
    }
  }
  return sum / sum.sum();
}

TEST(SimulatorCamera, AClassIsKnownByItsColour) {
  const Image image = view(
      ", landmarks: { list_m: [5, 1.5, 0.3, 5, 0.5, 0.3, 5, -0.5, 0.3, 5, -1.5, 0.3], textures: 4,"
      "  list_texture: [0, 1, 0, 2], seed: 3 }",
      mounted(0, 0, 0));
  const Eigen::Vector3d first = tint(image, 1.5);
  EXPECT_LT((first - tint(image, -0.5)).norm(), 0.03);
  EXPECT_GT((first - tint(image, 0.5)).norm(), 0.1);
  EXPECT_GT((first - tint(image, -1.5)).norm(), 0.1);
  EXPECT_GT((tint(image, 0.5) - tint(image, -1.5)).norm(), 0.1);
}

TEST(SimulatorCamera, PixelNoiseHasTheStatedSigmaAndIsNewInEveryImage) {
  const auto images = record("duration_s: 8",
                             "rate_hz: 2, noise_sigma: 3, lighting: { brightness_sigma: 0, colour_sigma: 0 },"
                             " exposure: { sigma: 0, gain: 0.6 }",
                             mounted(0, 0, 0));
  const Image& a = images[images.size() - 2].as<Image>();
  const Image& b = images.back().as<Image>();
  double sum = 0.0;
  double squares = 0.0;
  for (std::size_t i = 0; i < a.data.size(); ++i) {
    const double difference = static_cast<double>(a.data[i]) - static_cast<double>(b.data[i]);
    sum += difference;
    squares += difference * difference;
  }
  const auto n = static_cast<double>(a.data.size());
  EXPECT_NEAR(sum / n, 0.0, 0.05);
  EXPECT_NEAR(std::sqrt(squares / n), std::sqrt(2.0 * (9.0 + 1.0 / 12.0)), 0.1);  // rounding adds 1/12
}

TEST(SimulatorCamera, TheLightChangesSlowlyAndOnlyWhenAsked) {
  const auto brightness = [](const std::string& lighting) {
    std::vector<double> means;
    for (const Measurement& m : record("duration_s: 104",
                                       "rate_hz: 1, noise_sigma: 0, exposure: { sigma: 0, gain: 0.4,"
                                       " compensation: 0 }, lighting: { time_s: 20, " +
                                           lighting + " }",
                                       mounted(0, 0, 0), {64, 48, 50, 50, 32, 24, {}})) {
      if (m.stamp > Time{from_seconds(4.0)}) means.push_back(mean(m.as<Image>()));
    }
    return means;
  };
  const auto steady = brightness("brightness_sigma: 0, colour_sigma: 0");
  EXPECT_EQ(*std::ranges::min_element(steady), *std::ranges::max_element(steady));
  const auto daylight = brightness("brightness_sigma: 0.2, colour_sigma: 0");
  EXPECT_GT(*std::ranges::max_element(daylight) / *std::ranges::min_element(daylight), 1.2);
  for (std::size_t i = 1; i < daylight.size(); ++i) EXPECT_LT(std::abs(daylight[i] / daylight[i - 1] - 1.0), 0.1);
}

TEST(SimulatorCamera, BlackOverexposedAndMissingImagesComeWhenAsked) {
  const auto images = record("duration_s: 10", "rate_hz: 1, black_s: [2, 4], overexposed_s: [5, 7], outages_s: [8, 9]",
                             mounted(0, 0, 0), {64, 48, 50, 50, 32, 24, {}});
  ASSERT_EQ(images.size(), 9u);  // of ten
  EXPECT_LT(mean(images[2].as<Image>()), 3.0);
  EXPECT_LT(mean(images[3].as<Image>()), 3.0);
  EXPECT_GT(mean(images[4].as<Image>()), 60.0);
  EXPECT_LT(mean(images[4].as<Image>()), 220.0);
  EXPECT_GT(mean(images[5].as<Image>()), 250.0);
  EXPECT_GT(mean(images[6].as<Image>()), 250.0);
  EXPECT_LT(mean(images[7].as<Image>()), 220.0);
}

TEST(SimulatorCamera, RefusesAMountingThatItCannotDraw) {
  EXPECT_THROW(record("duration_s: 1", "rate_hz: 1", mounted(0, 80, 0)), ConfigError);
  EXPECT_THROW(record("duration_s: 1", "rate_hz: 1", Pose{}), ConfigError);  // on the ground
  const Rig no_lens({{.name = "camera", .payload = "", .T_base_sensor = mounted(0, 0, 0)}});
  EXPECT_THROW(make_with(no_lens, kShortDrive + ", duration_s: 1, camera: { sensor: camera } }"), ConfigError);
}

}  // namespace
}  // namespace waymark
