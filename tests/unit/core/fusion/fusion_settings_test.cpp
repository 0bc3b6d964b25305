// SPDX-License-Identifier: Apache-2.0
#include "waymark/host/fusion_settings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

namespace waymark {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr double kDeg = std::numbers::pi / 180.0;

FusionSettings read(const std::string& yaml) { return read_fusion_settings(Config::parse(yaml, "robot.yaml")); }

std::string error_of(const std::string& yaml) {
  try {
    read(yaml);
  } catch (const ConfigError& error) {
    return error.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return "";
}

SensorSlot sensor(const std::string& entry) { return read_sensor_slot(Config::parse(entry, "robot.yaml")); }

TEST(FusionSettings, AreAPlainPlanarEkfByDefault) {
  const FusionSettings s = read("{}");
  EXPECT_EQ(s.motion, StateLayout::Motion::planar);
  EXPECT_EQ(s.filter.particles, 1);
  EXPECT_EQ(s.filter.seed, 1U);
  EXPECT_EQ(s.max_latency, Duration{0});
  EXPECT_FALSE(s.start.position.has_value());
  EXPECT_FALSE(s.start.yaw.has_value());
  EXPECT_FALSE(s.datum.has_value());
}

TEST(FusionSettings, HaveTwentyFiveParticlesWithMaps) { EXPECT_EQ(read("maps: [{ name: a }]").filter.particles, 25); }

TEST(FusionSettings, AnEmptyListOfMapsIsNone) {
  EXPECT_EQ(read("maps: []").filter.particles, 1);
  EXPECT_TRUE(read("{ maps: [], filter: { smooth: true } }").smooth);
  EXPECT_THROW(read("{ maps: [{ name: a }], filter: { smooth: true } }"), ConfigError);
}

TEST(FusionSettings, AreReadWithTheirUnits) {
  const FusionSettings s = read(
      "motion: { kind: spatial, velocity_noise_mps_per_sqrt_s: [1, 2, 3], rate_noise_radps_per_sqrt_s: [4, 5, 6], "
      "standstill_after_s: 2 }\n"
      "initial: { x_m: 1, y_m: 2, z_m: 3, position_sigma_m: 0.5, yaw_deg: 90, yaw_sigma_deg: 2 }\n"
      "datum: { latitude_deg: 49, longitude_deg: 8 }\n"
      "filter: { particles: 7, seed: 9, resample_threshold: 0.25, sampling_fraction: 1, threads: 2, max_latency_s: 0.2 "
      "}\n");
  EXPECT_EQ(s.motion, StateLayout::Motion::spatial);
  EXPECT_EQ(s.process_noise.velocity_per_sqrt_s, Eigen::Vector3d(1.0, 2.0, 3.0));
  EXPECT_EQ(s.process_noise.rate_per_sqrt_s, Eigen::Vector3d(4.0, 5.0, 6.0));
  EXPECT_EQ(s.standstill_after, from_seconds(2.0));
  EXPECT_EQ(s.start.position, Eigen::Vector2d(1.0, 2.0));
  EXPECT_EQ(s.start.height, 3.0);
  EXPECT_NEAR(s.start.yaw.value_or(0.0), 90.0 * kDeg, 1e-15);
  EXPECT_NEAR(s.start.yaw_sigma, 2.0 * kDeg, 1e-15);
  EXPECT_EQ(s.datum.value_or(Datum{}).latitude_deg, 49.0);
  EXPECT_EQ(s.filter.particles, 7);
  EXPECT_EQ(s.filter.seed, 9U);
  EXPECT_EQ(s.filter.resample_threshold, 0.25);
  EXPECT_EQ(s.filter.sampling_fraction, 1.0);
  EXPECT_EQ(s.filter.threads, 2);
  EXPECT_EQ(s.max_latency, from_seconds(0.2));
}

TEST(FusionSettings, ErrorsNamePlaceKeyAndValue) {
  EXPECT_THAT(error_of("filter:\n  particles: 0\n"),
              AllOf(StartsWith("robot.yaml:2:"), HasSubstr("filter.particles"), HasSubstr("0")));
  EXPECT_THAT(error_of("filter:\n  sampling_fraction: 1.5\n"),
              AllOf(StartsWith("robot.yaml:2:"), HasSubstr("filter.sampling_fraction"), HasSubstr("1.5")));
  EXPECT_THAT(error_of("filter: { max_latency_s: -1 }"),
              AllOf(StartsWith("robot.yaml:1:"), HasSubstr("filter.max_latency_s")));
  EXPECT_THAT(error_of("motion: { kind: flying }"),
              AllOf(StartsWith("robot.yaml:1:"), HasSubstr("motion.kind"), HasSubstr("flying"), HasSubstr("spatial")));
  EXPECT_THAT(error_of("motion: { velocity_noise_mps_per_sqrt_s: [1, -1, 1] }"),
              AllOf(StartsWith("robot.yaml:1:"), HasSubstr("motion.velocity_noise_mps_per_sqrt_s")));
  EXPECT_THAT(error_of("motion: { rate_noise_radps_per_sqrt_s: [1, 1] }"),
              HasSubstr("motion.rate_noise_radps_per_sqrt_s"));
  EXPECT_THAT(error_of("initial: { x_m: 1 }"), AllOf(StartsWith("robot.yaml:1:"), HasSubstr("y_m")));
  EXPECT_THAT(error_of("initial: { yaw_deg: 400 }"), AllOf(HasSubstr("initial.yaw_deg"), HasSubstr("400")));
  EXPECT_THAT(error_of("datum: { latitude_deg: 95, longitude_deg: 0 }"),
              AllOf(HasSubstr("datum.latitude_deg"), HasSubstr("95")));
}

TEST(SensorSlot, HasDefaults) {
  const SensorSlot slot = sensor("{ name: gps, plugin: dgps }");
  EXPECT_EQ(slot.name, "gps");
  EXPECT_EQ(slot.plugin, "dgps");
  EXPECT_TRUE(slot.enabled);
  EXPECT_EQ(slot.fuse.mode, FuseRule::Mode::all);
  EXPECT_EQ(slot.gate_probability, 0.999);
  EXPECT_EQ(slot.weight_exponent, 1.0);
  EXPECT_EQ(slot.max_consecutive_rejections, 20);
}

TEST(SensorSlot, ReadsTheFuseRules) {
  using Mode = FuseRule::Mode;
  const std::vector<std::pair<std::string, Mode>> modes = {{"all", Mode::all},
                                                           {"start", Mode::start},
                                                           {"alternate", Mode::alternate},
                                                           {"stretches", Mode::stretches},
                                                           {"none", Mode::none}};
  for (const auto& [word, mode] : modes) EXPECT_EQ(sensor("{ name: gps, fuse: " + word + " }").fuse.mode, mode);
  const FuseRule rule = sensor("{ name: gps, fuse: alternate, fuse_on_s: 3, fuse_off_s: 4, fuse_gap_s: 5 }").fuse;
  EXPECT_EQ(rule.on, from_seconds(3.0));
  EXPECT_EQ(rule.off, from_seconds(4.0));
  EXPECT_EQ(rule.gap, from_seconds(5.0));
}

TEST(SensorSlot, RefusesWhatMakesNoSense) {
  for (const char* wrong : {"gate_probability: 1", "gate_probability: 0.1", "weight_exponent: 2", "fuse: sometimes",
                            "fuse_on_s: 0", "max_consecutive_rejections: -1", "enabled: perhaps"}) {
    EXPECT_THROW(sensor("{ name: gps, " + std::string(wrong) + " }"), ConfigError) << wrong;
  }
  EXPECT_THROW(sensor("{ plugin: dgps }"), ConfigError);
}

TEST(Mounting, CompletesThePayloadAndReadsTheExtrinsics) {
  const Mounting m = read_mounting(
      Config::parse("{ name: lidar, payload: LaserScan, base_T_sensor: { xyz_m: [1, 2, 3], yaw_deg: 90 } }"));
  EXPECT_EQ(m.payload, "waymark/LaserScan@1");
  ASSERT_TRUE(m.T_base_sensor.has_value());
  EXPECT_EQ(m.T_base_sensor.value_or(Pose{}).p, Eigen::Vector3d(1.0, 2.0, 3.0));
  EXPECT_NEAR(m.T_base_sensor.value_or(Pose{}).yaw(), 90.0 * kDeg, 1e-12);
  EXPECT_EQ(read_mounting(Config::parse("{ name: x, payload: vendor/Thing@2 }")).payload, "vendor/Thing@2");
  EXPECT_FALSE(read_mounting(Config::parse("{ name: x }")).T_base_sensor.has_value());
}

TEST(Mounting, RefusesAListForThePoseWithWhatIsExpected) {
  try {
    read_mounting(Config::parse("{ name: x, base_T_sensor: [0.2, 0, 0.3] }", "robot.yaml"));
    FAIL() << "nothing was thrown";
  } catch (const ConfigError& error) {
    EXPECT_STREQ(error.what(),
                 "robot.yaml:1:27: base_T_sensor: a list is not a mapping; write { xyz_m: [x, y, z], yaw_deg: 0 }");
  }
}

TEST(Mounting, ReadsTheIntrinsicsOfACamera) {
  const Mounting m = read_mounting(
      Config::parse("{ name: front, payload: Image, intrinsics: { size_px: [640, 480], focal_px: [500, 501],"
                    " center_px: [320.5, 240], distortion: [-0.2, 0.1, 0, 0, 0.01] } }"));
  const Intrinsics camera = m.intrinsics.value_or(Intrinsics{});
  EXPECT_EQ(camera.width, 640);
  EXPECT_EQ(camera.height, 480);
  EXPECT_EQ(camera.fy, 501.0);
  EXPECT_EQ(camera.cx, 320.5);
  EXPECT_EQ(camera.distortion, (std::array<double, 5>{-0.2, 0.1, 0.0, 0.0, 0.01}));
}

TEST(Mounting, RejectsIntrinsicsThatNoCameraHas) {
  EXPECT_THROW(read_mounting(Config::parse(
                   "{ name: x, intrinsics: { size_px: [640.5, 480], focal_px: [5, 5], center_px: [3, 2] } }")),
               ConfigError);
  EXPECT_THROW(read_mounting(Config::parse(
                   "{ name: x, intrinsics: { size_px: [640, 480], focal_px: [5, 0], center_px: [3, 2] } }")),
               ConfigError);
}

class Shares : public ::testing::Test {
 protected:
  static std::vector<MapSlot> normalize(const std::string& maps) {
    const Config yaml = Config::parse("maps:\n" + maps, "robot.yaml");
    const Rig rig({{.name = "lidar", .payload = "", .T_base_sensor = {}},
                   {.name = "camera", .payload = "", .T_base_sensor = {}}});
    std::vector<MapSlot> slots;
    for (const Config& entry : yaml.items("maps")) slots.push_back(read_map_slot(entry, rig));
    normalize_shares(slots, yaml);
    return slots;
  }
};

TEST_F(Shares, AreEqualByDefaultAmongMapsWithOneTrigger) {
  const auto slots = normalize(
      "  - { name: a, plugin: p, inputs: [lidar] }\n"
      "  - { name: b, plugin: p, inputs: [lidar, camera] }\n"
      "  - { name: c, plugin: p, inputs: camera }\n");
  EXPECT_DOUBLE_EQ(slots[0].share, 0.5);
  EXPECT_DOUBLE_EQ(slots[1].share, 0.5);
  EXPECT_DOUBLE_EQ(slots[2].share, 1.0);
  EXPECT_EQ(slots[1].inputs, (std::vector<int>{0, 1}));
}

TEST_F(Shares, AMapThatOnlyMapsTakesNone) {
  const auto slots = normalize(
      "  - { name: a, plugin: p, inputs: [lidar] }\n"
      "  - { name: b, plugin: p, inputs: [lidar], localize: false }\n");
  EXPECT_DOUBLE_EQ(slots[0].share, 1.0);
  EXPECT_DOUBLE_EQ(slots[1].share, 0.0);
}

TEST_F(Shares, MayBeGiven) {
  const auto slots = normalize(
      "  - { name: a, plugin: p, inputs: [lidar], information_share: 0.3 }\n"
      "  - { name: b, plugin: p, inputs: [lidar], information_share: 0.7 }\n");
  EXPECT_DOUBLE_EQ(slots[0].share, 0.3);
  EXPECT_DOUBLE_EQ(slots[1].share, 0.7);
}

TEST_F(Shares, AboveOneInSumAreRefused) {
  try {
    normalize(
        "  - { name: a, plugin: p, inputs: [lidar], information_share: 0.6 }\n"
        "  - { name: b, plugin: p, inputs: [lidar], information_share: 0.6 }\n");
    FAIL() << "nothing was thrown";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(),
                AllOf(StartsWith("robot.yaml:"), HasSubstr("maps"), HasSubstr("1.2"), HasSubstr("at most 1")));
  }
}

TEST_F(Shares, AnInputThatIsNoSensorIsRefused) {
  try {
    normalize("  - { name: a, plugin: p, inputs: [sonar] }\n");
    FAIL() << "nothing was thrown";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(),
                AllOf(StartsWith("robot.yaml:2:"), HasSubstr("inputs"), HasSubstr("\"sonar\" is not a sensor")));
  }
  EXPECT_THROW(normalize("  - { name: a, plugin: p, inputs: [] }\n"), ConfigError);
}

}  // namespace
}  // namespace waymark
