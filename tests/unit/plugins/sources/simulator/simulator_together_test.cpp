// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "simulated_log.hpp"

namespace waymark {
namespace {

using test::make_with;
using test::read_all;

Rig full_rig() {
  const Pose T_base_camera{so3::from_rpy(0.0, 0.05, 0.0), {0.2, 0.0, 0.9}};
  return Rig({{.name = "wheels", .payload = "", .T_base_sensor = {}},
              {.name = "gps", .payload = "", .T_base_sensor = {}},
              {.name = "lidar", .payload = "", .T_base_sensor = Pose{Eigen::Quaterniond::Identity(), {0.3, 0.0, 0.25}}},
              {.name = "lidar_3d", .payload = "", .T_base_sensor = Pose{so3::from_rpy(0.1, 0.2, 0.3), {0.0, 0.1, 0.7}}},
              {.name = "camera",
               .payload = "",
               .T_base_sensor = T_base_camera,
               .intrinsics = Intrinsics{160, 120, 130.0, 130.0, 80.0, 60.0, {-0.1, 0.0, 0.0, 0.0, 0.0}}},
              {.name = "imu", .payload = "", .T_base_sensor = Pose{}},
              {.name = "compass", .payload = "", .T_base_sensor = Pose{}},
              {.name = "radar", .payload = "", .T_base_sensor = Pose{so3::from_rpy(0.0, 0.0, 0.4), {0.4, 0.1, 0.3}}}});
}

const std::string kWorld =
    "duration_s: 20, course: { waypoints_m: [0, 0, 12, 0, 12, 8, 0, 8] },"
    " landmarks: { count: 10, area_m: [-5, -5, 17, 13], seed: 7, textures: 3, metal_textures: [1] },"
    " walls_m: [-7, -7, 19, -7], clutter: { stones: 3, boxes: 3, corners: 1, area_m: [-6, -6, 18, 14] }";

const std::vector<std::string> kSensors = {
    ", wheels: { sensor: wheels, track_m: 0.5 }",
    ", gps: { sensor: gps, correlated_sigma_m: 0.5, satellite_change_mean_s: 4 }",
    ", lidar: { sensor: lidar, beams: 90, step_deg: 3, beam_width_deg: 1 }",
    ", lidar_3d: { sensor: lidar_3d, beams: 60, step_deg: 6, rings: 4 }",
    ", camera: { sensor: camera, rate_hz: 3 }",
    ", imu: { sensor: imu, rate_hz: 50 }",
    ", compass: { sensor: compass }",
    ", traffic: { count: 3, area_m: [-5, -5, 17, 13] }, radars: [{ sensor: radar, rays: 20, false_alarms_per_scan: 3 "
    "}]"};

std::string all_sensors() {
  std::string all;
  for (const std::string& sensor : kSensors) all += sensor;
  return all;
}

std::shared_ptr<Source> simulate(const std::string& sensors, int seed = 3) {
  return make_with(full_rig(), "{ seed: " + std::to_string(seed) + ", " + kWorld + sensors + " }");
}

/// Everything that a measurement says, bit by bit.
std::vector<std::uint64_t> bits_of(const Measurement& m) {
  std::vector<std::uint64_t> bits{static_cast<std::uint64_t>(m.stamp.time_since_epoch().count())};
  const auto add = [&](double value) { bits.push_back(std::bit_cast<std::uint64_t>(value)); };
  const auto add3 = [&](const Eigen::Vector3d& v) { std::ranges::for_each(v, add); };
  const std::string_view type = m.payload->type();
  if (type == WheelSpeeds::kType) {
    add(m.as<WheelSpeeds>().left_mps);
    add(m.as<WheelSpeeds>().right_mps);
  } else if (type == GnssFix::kType) {
    add3(m.as<GnssFix>().p_map_antenna);
    add(m.as<GnssFix>().hdop);
  } else if (type == LaserScan::kType) {
    for (const float range : m.as<LaserScan>().ranges_m) add(range);
  } else if (type == PointCloud::kType) {
    for (const Eigen::Vector3f& point : m.as<PointCloud>().points_m) add3(point.cast<double>());
  } else if (type == Image::kType) {
    for (const std::uint8_t value : m.as<Image>().data) bits.push_back(value);
  } else if (type == ImuSample::kType) {
    add3(m.as<ImuSample>().w_sensor);
    add3(m.as<ImuSample>().f_sensor);
    add3(m.as<ImuSample>().m_sensor);
  } else if (type == RadarTargets::kType) {
    for (const RadarTargets::One& one : m.as<RadarTargets>().targets)
      add3({one.range_m, one.azimuth_rad, one.radial_mps});
  } else {
    add(m.as<CompassHeading>().heading_rad);
  }
  return bits;
}

std::vector<std::vector<std::uint64_t>> bits_of(Source& source, std::string_view sensor) {
  std::vector<std::vector<std::uint64_t>> bits;
  for (const Measurement& m : read_all(source)) {
    if (source.channels()[m.sensor].sensor == sensor) bits.push_back(bits_of(m));
  }
  return bits;
}

TEST(SimulatorTogether, EqualSeedsGiveEqualBytesAndOthersDoNot) {
  const auto a = read_all(*simulate(all_sensors()));
  const auto b = read_all(*simulate(all_sensors()));
  const auto c = read_all(*simulate(all_sensors(), 4));
  ASSERT_EQ(a.size(), b.size());
  ASSERT_GT(a.size(), 2000u);
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(bits_of(a[i]), bits_of(b[i]));
    ASSERT_EQ(a[i].sensor, c[i].sensor);
  }
  for (std::uint32_t sensor = 0; sensor < kSensors.size(); ++sensor) {
    bool differs = false;
    for (std::size_t i = 0; i < a.size(); ++i) {
      differs = differs || (a[i].sensor == sensor && bits_of(a[i]) != bits_of(c[i]));
    }
    EXPECT_TRUE(differs) << kSensors[sensor];
  }
}

TEST(SimulatorTogether, SwitchingASensorOffLeavesTheOthersAlone) {
  for (const std::string& alone : kSensors) {
    const auto source = simulate(alone);
    const std::string sensor = source->channels().front().sensor;
    const auto together = bits_of(*simulate(all_sensors()), sensor);
    ASSERT_FALSE(together.empty());
    ASSERT_EQ(together, bits_of(*source, sensor)) << sensor;
  }
}

TEST(SimulatorTogether, NoTwoSensorsMeasureAtTheSameTime) {
  const auto all = read_all(*simulate(all_sensors()));
  for (std::size_t i = 1; i < all.size(); ++i) ASSERT_LT(all[i - 1].stamp, all[i].stamp);
}

TEST(SimulatorTogether, ReadsEveryKeyOfItsReadme) {
  const Config config = Config::parse(
      "{ duration_s: 5, course: { waypoints_m: [0, 0, 5, 0, 5, 5] }, walls_m: [9, 9, 8, 9], wall_height_m: 2,"
      "  boxes_m: [9, 0, 1, 2, 0.5], ground: true, ceiling_m: 4, surfaces_file: truth.csv,"
      "  landmarks: { list_m: [2, 9, 0.2, 4, 9, 0.2], seed: 2, height_m: [2, 3], textures: 3, list_texture: [0, 2],"
      "               metal_textures: [2] },"
      "  clutter: { stones: 1, boxes: 1, corners: 1, area_m: [-9, -9, 9, 9], seed: 3, course_clearance_m: 0.5,"
      "             min_distance_m: 0.4, stone_radius_m: [0.1, 0.2], stone_height_m: [0.3, 0.4],"
      "             box_size_m: [0.2, 0.3], box_height_m: [0.3, 0.4], corner_size_m: [0.5, 0.6] },"
      "  magnetism: { earth_field_t: [0, 2e-5, -4e-5], metal_moment_am2: 10, disturbers: [1, 8, 20] },"
      "  wheels: { sensor: wheels, track_m: 0.5, spins_s: [1, 2], spin_ratio: 0.2 },"
      "  gps: { sensor: gps, satellite_change_mean_s: 30, jump_sigma_m: 0.5 },"
      "  lidar: { sensor: lidar, miss_probability: 0.1, clutter_per_scan: 1, beam_width_deg: 0.5,"
      "           mixed_probability: 0.4, edge_m: 0.2 },"
      "  lidar_3d: { sensor: lidar_3d, rings: 8, elevation_min_deg: -20, elevation_max_deg: 10, start_deg: -90,"
      "              step_deg: 0.5, beams: 100, range_max_m: 20, sigma_m: 0.01, sweep_s: 0.05, nan_s: [1, 2] },"
      "  camera: { sensor: camera, rate_hz: 5, delay_s: 0.1, noise_sigma: 1, outages_s: [1, 2], black_s: [2, 3],"
      "            overexposed_s: [3, 4], exposure: { gain: 1, sigma: 0.01, compensation: 0.5 },"
      "            lighting: { brightness_sigma: 0.1, colour_sigma: 0.1, time_s: 30, sun_azimuth_deg: 20,"
      "                        shading: 0.3 } },"
      "  imu: { sensor: imu, rate_hz: 100, delay_s: 0, magnetometer: true, magnetometer_noise_t: 1e-7,"
      "         gyroscope_noise_radps_per_sqrt_hz: 1e-4, gyroscope_bias_sigma_radps: 1e-3,"
      "         gyroscope_bias_walk_radps_per_sqrt_s: 1e-5, accelerometer_noise_mps2_per_sqrt_hz: 1e-3,"
      "         accelerometer_bias_sigma_mps2: 0.01, accelerometer_bias_walk_mps2_per_sqrt_s: 1e-4 },"
      "  compass: { sensor: compass, rate_hz: 10, delay_s: 0, sigma_deg: 1, offset_deg: 2 },"
      "  traffic: { count: 2, area_m: [-9, -9, 9, 9], speed_mps: [1, 2] },"
      "  radars: [{ sensor: radar, rate_hz: 10, range_max_m: 30, view_deg: 90, rise_deg: 20, rays: 50,"
      "             range_sigma_m: 0.1, azimuth_sigma_deg: 0.2, elevation_sigma_deg: 0.5, radial_sigma_mps: 0.1,"
      "             radial_max_mps: 30, false_alarms_per_scan: 2, targets_per_thing: 3, multipath_probability: 0.1,"
      "             delay_s: 0.01 }] }");
  PluginLoader({WAYMARK_PLUGIN_DIR}).create<Source>("simulator", config, full_rig());
  EXPECT_NO_THROW(config.reject_unread());
}

}  // namespace
}  // namespace waymark
