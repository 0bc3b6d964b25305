// SPDX-License-Identifier: Apache-2.0
// needs plugins: csv, dgps, diagnostics, feature_map, landmarks, odometry, tum
// YAML files with errors: `check` and `run` report one in one line with its place, and write nothing.
#include <gmock/gmock.h>

#include "tests/system/small_robot.hpp"

namespace waymark::system_test {
namespace {

/// A change of the YAML that makes it wrong. The message must name the line of `where`.
struct Mistake {
  const char* name;
  const char* old_text;
  const char* new_text;
  const char* where;
  std::vector<std::string> expected;
};

void PrintTo(const Mistake& mistake, std::ostream* out) { *out << mistake.name; }

class BadYaml : public testing::TestWithParam<Mistake> {
 protected:
  BadYaml() {
    robot_.replace(GetParam().old_text, GetParam().new_text);
    expected_ = GetParam().expected;
    expected_.push_back(robot_.place("robot.yaml", robot_.yaml_line(GetParam().where)) + ":");
  }
  SmallRobot robot_;
  std::vector<std::string> expected_;
};

TEST_P(BadYaml, CheckSaysSoInOneLine) { EXPECT_TRUE(reports_error(robot_.check(), 1, expected_)); }

TEST_P(BadYaml, RunSaysSoInOneLineAndWritesNothing) {
  EXPECT_TRUE(reports_error(robot_.run(), 1, expected_));
  EXPECT_FALSE(std::filesystem::exists(robot_.out()));
}

std::string name_of(const testing::TestParamInfo<Mistake>& info) { return info.param.name; }

INSTANTIATE_TEST_SUITE_P(
    Keys, BadYaml,
    testing::Values(
        Mistake{"Unknown",
                "sigma_m: 0.3",
                "sigma_m: 0.3\n    offset_sigmam: 0.2",
                "offset_sigmam",
                {"offset_sigmam", "offset_sigma_m"}},
        Mistake{"UnknownAtTheTop", "filter:", "filters: {}\nfilter:", "filters: {}", {"filters", "\"filter\""}},
        Mistake{"WrongType", "particles: 5", "particles: many", "particles: many", {"filter.particles", "many"}},
        Mistake{"ListForANumber", "sigma_m: 0.3", "sigma_m: [0.3, 0.4]", "sigma_m: [", {"sigma_m", "number"}},
        Mistake{"NumberForAList", "inputs: [lidar]", "inputs: 3", "inputs: 3", {"inputs", "3"}},
        Mistake{"NotFinite", "sigma_m: 0.3", "sigma_m: .nan", "sigma_m: .nan", {"sigma_m", "nan"}},
        Mistake{"AngleOutOfRange", "yaw_deg: 0,", "yaw_deg: 7200,", "yaw_deg: 7200", {"initial.yaw_deg", "7200"}},
        Mistake{"ProbabilityOutOfRange",
                "sigma_m: 0.3",
                "sigma_m: 0.3\n    gate_probability: 99",
                "gate_probability",
                {"gate_probability", "99"}},
        Mistake{"NoParticles", "particles: 5", "particles: 0", "particles: 0", {"filter.particles", "0"}},
        Mistake{"Twice", "sigma_m: 0.3", "sigma_m: 0.3\n    sigma_m: 0.4", "sigma_m: 0.4", {"sigma_m", "twice"}},
        Mistake{"UnsetVariable",
                "path: twist.csv",
                "path: ${WAYMARK_TEST_UNSET}/twist.csv",
                "${WAYMARK",
                {"WAYMARK_TEST_UNSET"}},
        Mistake{"NoYaml", "filter: {", "filter: [{", "sinks:", {"end of sequence flow not found"}}),
    name_of);

INSTANTIATE_TEST_SUITE_P(
    Robot, BadYaml,
    testing::Values(
        Mistake{"NegativeNoise", "sigma_m: 0.3", "sigma_m: -0.3", "sigma_m: -0.3", {"sigma_m", "-0.3"}},
        Mistake{
            "ZeroNoise", "sigma_m: 0.3", "sigma_m: 0", "    sigma_m: 0\n", {"sensors.gps.sigma_m", "0 must be > 0"}},
        Mistake{"ZeroOdometryNoise",
                "model: twist",
                "model: twist\n    speed_noise_m_per_sqrt_s: [0, 0]",
                "speed_noise",
                {"speed_noise_m_per_sqrt_s"}},
        Mistake{"NegativeMapNoise", "range_m: 0.05", "range_m: -0.05", "range_m: -0.05", {"noise.range_m", "-0.05"}},
        Mistake{"ZeroMapNoise", "range_m: 0.05", "range_m: 0", "range_m: 0", {"noise.range_m", "0"}},
        Mistake{"ExtrinsicsMissing",
                "    base_T_sensor: { xyz_m: [0, 0, 0], yaw_deg: 0 }\n",
                "",
                "name: pillars",
                {"lidar", "base_T_sensor"}},
        Mistake{"LeverArmMissing", "    base_p_antenna_m: [0, 0, 0]\n", "", "name: gps", {"base_p_antenna_m"}},
        Mistake{"SensorNameTwice",
                "name: gps",
                "name: wheels",
                "name: wheels\n    plugin: dgps",
                {"\"wheels\"", "two sensors"}},
        Mistake{"NoSensors", "sensors:", "sensors: []\nrest:", "sensors: []", {"sensors"}},
        Mistake{"MapOfAnUnknownSensor", "inputs: [lidar]", "inputs: [ladar]", "inputs: [ladar]", {"ladar", "lidar"}},
        Mistake{"FileOfAnUnknownSensor", "sensor: gps", "sensor: gsp", "sensor: gsp", {"gsp", "gps"}},
        Mistake{"WrongPayload", "payload: GnssFix", "payload: GnsFix", "payload: GnsFix", {"GnsFix", "GnssFix"}},
        Mistake{"UnknownColumn", "east_m: east_m", "east_m: east", "east_m: east", {"\"east\"", "\"east_m\""}}),
    name_of);

TEST(BadRobot, TwoSensorsOnOneInput) {
  SmallRobot robot;
  robot.replace("  - name: lidar\n", "  - name: twin\n    plugin: odometry\n    model: twist\n  - name: lidar\n");
  robot.replace("    - path: fixes.csv",
                "    - path: twist.csv\n      sensor: twin\n      payload: BodyTwist\n      time: t_s\n"
                "      columns: { v_x_mps: v_mps, w_z_radps: w_radps }\n    - path: fixes.csv");
  EXPECT_TRUE(reports_error(robot.check(), 1,
                            {robot.place("robot.yaml", robot.yaml_line("sensor: twin")), "two sensors on one input",
                             "\"wheels\"", "\"twin\""}));
}

TEST(BadRobot, NoMotionSensor) {
  SmallRobot robot;
  robot.replace("plugin: odometry\n    model: twist", "payload: BodyTwist");
  const std::vector<std::string> expected{robot.file("robot.yaml").string() + ": sensors: ", "measures the motion",
                                          "plugin: odometry"};
  EXPECT_TRUE(reports_error(robot.check(), 1, expected));
  EXPECT_TRUE(reports_error(robot.run(), 1, expected));
  EXPECT_FALSE(std::filesystem::exists(robot.out()));
}

TEST(BadRobot, OverrideOfAnUnknownKey) {
  SmallRobot robot;
  EXPECT_TRUE(reports_error(robot.run({"--set", "filter.particels=3"}), 1, {"--set", "filter.particels", "particles"}));
}

TEST(BadRobot, OverrideWithoutAValue) {
  SmallRobot robot;
  EXPECT_TRUE(reports_error(robot.run({"--set", "filter.particles"}), 1, {"--set", "filter.particles", "="}));
}

}  // namespace
}  // namespace waymark::system_test
