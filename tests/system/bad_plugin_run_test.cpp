// SPDX-License-Identifier: Apache-2.0
// needs plugins: csv, dgps, diagnostics, feature_map, landmarks, mcap, odometry, recorder, tum
// Plugins that fail, and places where nothing can be written.
#include <gmock/gmock.h>
#include <sys/resource.h>

#include <nlohmann/json.hpp>

#include "tests/system/small_robot.hpp"

namespace waymark::system_test {
namespace {

using testing::HasSubstr;
using testing::SizeIs;

/// The small robot with a further sensor, fed from a file of its own, with the given plugin.
void add_sensor(SmallRobot& robot, const std::string& plugin) {
  robot.replace("motion:", fmt::format("plugin_path: [\"{}\"]\nmotion:", WAYMARK_BAD_PLUGIN_DIR));
  robot.replace("  - name: lidar\n", fmt::format("  - name: extra\n    plugin: {}\n  - name: lidar\n", plugin));
  robot.replace("    - path: fixes.csv",
                "    - path: extra.csv\n      sensor: extra\n      payload: BodyTwist\n      time: t_s\n"
                "      columns: { v_x_mps: v_mps, w_z_radps: w_radps }\n    - path: fixes.csv");
  std::string text;
  for (const std::string& line : robot.twist) text += line + "\n";
  write_text(robot.file("extra.csv"), text);
}

struct BadPlugin {
  const char* name;
  std::vector<std::string> expected;
};

void PrintTo(const BadPlugin& plugin, std::ostream* out) { *out << plugin.name; }

class BadPluginRun : public testing::TestWithParam<BadPlugin> {};

TEST_P(BadPluginRun, IsOneLineWithItsPlaceAndWritesNothing) {
  SmallRobot robot;
  add_sensor(robot, GetParam().name);
  std::vector<std::string> expected = GetParam().expected;
  expected.push_back(robot.file("robot.yaml").string() + ":");
  expected.emplace_back("sensors.extra");
  EXPECT_TRUE(reports_error(robot.run(), 1, expected));
  EXPECT_FALSE(std::filesystem::exists(robot.out()));
}

INSTANTIATE_TEST_SUITE_P(
    Plugin, BadPluginRun,
    testing::Values(BadPlugin{"odometri",
                              {"\"odometri\" is not found", WAYMARK_BAD_PLUGIN_DIR, "did you mean \"odometry\"?"}},
                    BadPlugin{"not_a_library", {"waymark_not_a_library.so", "library"}},
                    BadPlugin{"no_symbol", {"waymark_no_symbol.so", "waymark_plugin"}},
                    BadPlugin{"unresolved", {"waymark_unresolved.so"}},
                    BadPlugin{"wrong_abi", {"waymark_wrong_abi.so", "999"}},
                    BadPlugin{"wrong_build_key", {"waymark_wrong_build_key.so", "cxxabi=1"}},
                    BadPlugin{"wrong_alignment", {"waymark_wrong_alignment.so", "4096"}},
                    BadPlugin{"wrong_kind", {"waymark_wrong_kind.so", "\"sink\"", "\"sensor\""}},
                    BadPlugin{"throws_runtime_error", {"throws_runtime_error", "the device does not answer"}},
                    BadPlugin{"throws_int", {"throws_int", "std::exception"}}),
    [](const auto& plugin) { return std::string(plugin.param.name); });

TEST(PluginConstruction, KeepsThePlaceThatThePluginNames) {
  SmallRobot robot;
  add_sensor(robot, "throws_error");
  EXPECT_TRUE(reports_error(robot.run(), 1, {"calibration.bin:7: 3 columns, expected 4"}));
  EXPECT_FALSE(std::filesystem::exists(robot.out()));
}

TEST(PluginThatCallsExit, EndsTheRunWithAnError) {
  for (const char* plugin : {"exits_at_load", "exits_when_built"}) {
    SCOPED_TRACE(plugin);
    SmallRobot robot;
    add_sensor(robot, plugin);
    EXPECT_TRUE(reports_error(robot.run(), 1, {"a plugin ended the program"}));
    EXPECT_FALSE(std::filesystem::exists(robot.out()));
  }
}

TEST(PluginPath, OfTheYamlIsNoted) {
  SmallRobot robot;
  add_sensor(robot, "throws_at_1000");
  const std::string note =
      fmt::format("note: plugin_path of the YAML: plugins are searched in {} first\n", WAYMARK_BAD_PLUGIN_DIR);
  EXPECT_THAT(robot.run().err, HasSubstr("waymark: " + note));
  EXPECT_THAT(robot.check().out, HasSubstr("\n" + note));
}

/// A record is data, and may come from anybody.
TEST(PluginPath, OfAFlightRecordIsRefusedUnlessPermitted) {
  SmallRobot robot;
  add_sensor(robot, "throws_at_1000");
  robot.replace("sinks:\n", "sinks:\n  - { plugin: recorder }\n");
  ASSERT_EQ(robot.run().exit_code, 3) << "the plugin fails at measurement 1000";
  const std::string record = (robot.out() / "flight.mcap").string();
  const auto replay = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments{"run", record, "--out", robot.file("replay").string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return waymark(arguments);
  };
  EXPECT_TRUE(reports_error(replay({}), 1, {"flight.mcap", "plugin_path", WAYMARK_BAD_PLUGIN_DIR, "--set"}));
  EXPECT_FALSE(std::filesystem::exists(robot.file("replay")));
  EXPECT_TRUE(reports_error(replay({"--set", "plugin_path=[]"}), 1, {"\"throws_at_1000\" is not found"}));
  EXPECT_EQ(replay({"--set", fmt::format("plugin_path=[\"{}\"]", WAYMARK_BAD_PLUGIN_DIR)}).exit_code, 3);
}

TEST(PluginsCommand, ListsBadPluginsAndSaysWhatIsWrong) {
  const Outcome list = waymark({"plugins", "--path", WAYMARK_BAD_PLUGIN_DIR});
  EXPECT_EQ(list.exit_code, 0) << list.err;
  EXPECT_THAT(list.out, HasSubstr("waymark_exits_at_load.so\n"));
  EXPECT_THAT(list.out, HasSubstr("built for plugin ABI 999"));
  EXPECT_TRUE(reports_error(waymark({"plugins", "wrong_abi", "--path", WAYMARK_BAD_PLUGIN_DIR}), 1,
                            {"plugin \"wrong_abi\" does not fit", "ABI 999"}));
}

TEST(PluginsInspect, PrintsTheDescriptorAndEndsWithAnErrorIfItWouldBeRefused) {
  const std::string folder = WAYMARK_BAD_PLUGIN_DIR;
  const Outcome good = waymark({"plugins", "inspect", folder + "/waymark_throws_at_1000.so"});
  EXPECT_EQ(good.exit_code, 0) << good.err;
  for (const char* line : {"kind       sensor\n", "name       throws_at_1000\n", "version    1.0.0\n",
                           "build key  cxxabi=", "alignment  ", "fits       yes"})
    EXPECT_THAT(good.out, HasSubstr(line));
  const Outcome other = waymark({"plugins", "inspect", folder + "/waymark_wrong_build_key.so"});
  EXPECT_TRUE(reports_error(other, 1, {"waymark_wrong_build_key.so", "rebuild the plugin"}));
  EXPECT_THAT(other.out, HasSubstr("build key  cxxabi=1; this program has cxxabi="));
  const Outcome abi = waymark({"plugins", "inspect", folder + "/waymark_wrong_abi.so"});
  EXPECT_TRUE(reports_error(abi, 1, {"waymark_wrong_abi.so", "ABI 999"}));
  EXPECT_THAT(abi.out, HasSubstr("ABI        999; this program has "));
  EXPECT_TRUE(reports_error(waymark({"plugins", "inspect", folder + "/waymark_not_a_library.so"}), 1,
                            {"waymark_not_a_library.so", "invalid ELF header"}));
  EXPECT_TRUE(reports_error(waymark({"plugins", "inspect"}), 2, {"file is required", "waymark help plugins inspect"}));
}

TEST(PluginInService, ThrowsAtMeasurement1000AndTheRunGoesOnWithoutIt) {
  SmallRobot robot;
  add_sensor(robot, "throws_at_1000");
  EXPECT_TRUE(reports_error(robot.run(), 3,
                            {"at 19.980 s", "extra: taken out of service", "fails on purpose at measurement 1000"}));
  EXPECT_TRUE(robot.has_results(1500));
  const nlohmann::json report = nlohmann::json::parse(read_text(robot.out() / "diagnostics.json"));
  EXPECT_THAT(report["run"]["events"].dump(), HasSubstr("extra: taken out of service"));
  for (const nlohmann::json& sensor : report["sensors"]) {
    if (sensor["name"] == "extra") {
      EXPECT_EQ(sensor["measurements"], 1501);
      EXPECT_LE(sensor["fused"].get<int>(), 999);
    } else if (sensor["name"] == "gps") {
      EXPECT_EQ(sensor["fused"].get<int>() + sensor["gated"].get<int>(), 30);
    }
  }
}

TEST(OutputFolder, NotWritable) {
  const SmallRobot robot;
  robot.write();
  std::filesystem::create_directory(robot.out());
  std::filesystem::permissions(robot.out(), std::filesystem::perms(0555));
  const Outcome outcome = robot.command().in_child([] { drop_privileges(); }).run();
  EXPECT_TRUE(reports_error(outcome, 1, {robot.out().string() + ": ", "not writable"}));
}

TEST(OutputFolder, CannotBeCreated) {
  const SmallRobot robot;
  robot.write();
  const Outcome outcome = robot.command().in_child([] { drop_privileges(); }).run();
  EXPECT_TRUE(
      reports_error(outcome, 1, {robot.out().string() + ": ", "cannot create the output folder", "Permission denied"}));
}

TEST(OutputFolder, IsAFile) {
  const SmallRobot robot;
  robot.write();
  write_text(robot.out(), "something of the user's\n");
  EXPECT_TRUE(reports_error(robot.command().run(), 1, {robot.out().string() + ": ", "folder"}));
  EXPECT_EQ(read_text(robot.out()), "something of the user's\n");
}

void limit_file_size(rlim_t bytes) {
  const rlimit limit{bytes, bytes};
  ::setrlimit(RLIMIT_FSIZE, &limit);
}

TEST(FullDisk, KeepsTheResultsUntilThereInCompleteLines) {
  const SmallRobot robot;
  robot.write();
  const Outcome outcome = robot.command().in_child([] { limit_file_size(rlim_t{70000}); }).run();
  EXPECT_TRUE(reports_error(outcome, 3, {"sink tum", (robot.out() / "trajectory.txt").string(), "File too large"}));
  EXPECT_TRUE(has_complete_lines(robot.out() / "trajectory.txt", 500));
  EXPECT_LE(std::filesystem::file_size(robot.out() / "trajectory.txt"), 70000u);
  EXPECT_TRUE(has_complete_lines(robot.out() / "landmarks.csv", 2));
  EXPECT_TRUE(nlohmann::json::accept(read_text(robot.out() / "diagnostics.json")));
  EXPECT_TRUE(has_no_partial_file(robot.out()));
}

TEST(FullDisk, WithRoomForNothingIsOneLineAndLeavesNoHalfFile) {
  const SmallRobot robot;
  robot.write();
  // The captured stderr is a file as well, so some room is needed.
  const Outcome outcome = robot.command({"--quiet"}).in_child([] { limit_file_size(rlim_t{1000}); }).run();
  EXPECT_TRUE(reports_error(outcome, 1, {(robot.out() / "config.yaml").string(), "File too large"}));
  EXPECT_TRUE(has_no_partial_file(robot.out()));
  EXPECT_FALSE(std::filesystem::exists(robot.out() / "config.yaml"));
}

TEST(FullDisk, KeepsOlderResultsWhole) {
  const SmallRobot robot;
  ASSERT_EQ(robot.run().exit_code, 0);
  const std::string before = read_text(robot.out() / "config.yaml");
  const Outcome outcome = robot.command({"--quiet"}).in_child([] { limit_file_size(rlim_t{1000}); }).run();
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(read_text(robot.out() / "config.yaml"), before);
  EXPECT_TRUE(robot.has_results(1500));
}

}  // namespace
}  // namespace waymark::system_test
