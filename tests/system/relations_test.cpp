// SPDX-License-Identifier: Apache-2.0
// needs plugins: carmen, diagnostics, grid_map, occupancy_grid, odometry, plot, tum
// `waymark evaluate --relations`, and recorded logs of CARMEN through the whole host: dead reckoning is the log's own
// odometry, and the metric gives the figures that are known for these logs.
#include <gmock/gmock.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "tests/system/outputs.hpp"

namespace waymark::system_test {
namespace {

using testing::HasSubstr;

constexpr double kDegrees = 180.0 / std::numbers::pi;

nlohmann::json score(const std::vector<std::string>& arguments) {
  std::vector<std::string> all{"evaluate", "--json"};
  all.insert(all.end(), arguments.begin(), arguments.end());
  const Outcome outcome = waymark(all);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  return nlohmann::json::parse(outcome.out).at("relations");
}

struct Expected {
  int used;
  double mean_m, std_m, mean_deg, std_deg;
};

void expect(const nlohmann::json& found, const Expected& expected, double tolerance_m, double tolerance_deg) {
  const auto& all = found.at("all");
  EXPECT_EQ(all.at("used"), expected.used);
  EXPECT_NEAR(all.at("translation_mean_m").get<double>(), expected.mean_m, tolerance_m);
  EXPECT_NEAR(all.at("translation_std_m").get<double>(), expected.std_m, tolerance_m);
  EXPECT_NEAR(all.at("rotation_mean_rad").get<double>() * kDegrees, expected.mean_deg, tolerance_deg);
  EXPECT_NEAR(all.at("rotation_std_rad").get<double>() * kDegrees, expected.std_deg, tolerance_deg);
}

/// The relations under the dead reckoning of a log.
nlohmann::json dead_reckoning(const std::string& name, const std::vector<std::string>& more = {},
                              const std::string& sensor = "0,0") {
  const TemporaryFolder folder;
  const std::filesystem::path out = folder / "out";
  std::vector<std::string> run{
      "run",       WAYMARK_SOURCE_DIR "/config/carmen_" + name + ".yaml", "--quiet", "--set", "maps=[]", "--out",
      out.string()};
  run.insert(run.end(), more.begin(), more.end());
  const Outcome outcome = waymark(run);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const std::string data = data_folder() + "/carmen_" + name + "/" + name + ".relations";
  return score({"--estimate", (out / "path.txt").string(), "--relations", data, "--relations-sensor", sensor});
}

// The published odometry rows of these recordings, to their last digit.
TEST(CarmenLogs, DeadReckoningIsTheLogsOwnOdometry) {
  if (data_folder().empty()) GTEST_SKIP() << "WAYMARK_DATA is not set";
  const nlohmann::json intel = dead_reckoning("intel");
  expect(intel, {2984, 7.370, 14.349, 39.2, 53.8}, 6e-4, 0.06);
  EXPECT_EQ(intel.at("far_apart").at("used"), 1210);
  EXPECT_EQ(intel.at("poses"), intel.at("poses_at_row"));
  expect(dead_reckoning("fr079", {"--set", "source.wheels.reversals=as_logged"}, "-0.04,0"),
         {1685, 6.507, 13.657, 30.3, 45.5}, 6e-4, 0.06);
}

// Turning the reversals round must help; by how much is not known exactly.
TEST(CarmenLogs, RepairedReversalsAreNearerToTheTruth) {
  if (data_folder().empty()) GTEST_SKIP() << "WAYMARK_DATA is not set";
  const nlohmann::json repaired = dead_reckoning("fr079");
  EXPECT_LT(repaired.at("all").at("translation_mean_m").get<double>(), 0.85 * 6.507);
}

TEST(CarmenLogs, KnownPosesHaveTheirKnownErrors) {
  if (data_folder().empty()) GTEST_SKIP() << "WAYMARK_DATA is not set";
  const auto known = [](const std::string& name) {
    const std::filesystem::path folder = data_folder() + "/carmen_" + name;
    return score({"--estimate", (folder / (name + ".rbpf.txt")).string(), "--columns", "t=0,x=1,y=2,yaw=3",
                  "--max-time-gap", "1e-6", "--relations", (folder / (name + ".relations")).string()});
  };
  expect(known("fr079"), {1672, 0.058, 0.042, 0.70, 0.67}, 6e-4, 6e-3);
  expect(known("intel"), {90, 0.036, 0.027, 0.42, 0.46}, 6e-4, 6e-3);
}

TEST(Relations, AreShownAndNeedNoReference) {
  const TemporaryFolder folder;
  std::ofstream(folder / "estimate.txt") << "1 0 0 0 0 0 0.1 0.995\n2 1 0 0 0 0 0.1 0.995\n";
  std::ofstream(folder / "true.relations") << "1 2 1 0 0 0 0 0\n1 9 1 0 0 0 0 0\n";
  const std::string estimate = (folder / "estimate.txt").string();
  const std::string relations = (folder / "true.relations").string();
  const Outcome shown = waymark({"evaluate", "--estimate", estimate, "--relations", relations});
  EXPECT_EQ(shown.exit_code, 0) << shown.err;
  EXPECT_THAT(shown.out, HasSubstr("used                      1 of 2 (1 whose times the estimate does not cover)"));
  EXPECT_THAT(shown.out, HasSubstr("over 60 s apart           0 used"));

  const Outcome alone = waymark({"evaluate", "--relations", relations});
  EXPECT_NE(alone.exit_code, 0);
  EXPECT_THAT(alone.err, HasSubstr("--relations needs --estimate"));
  std::ofstream(folder / "late.relations") << "11 12 1 0 0 0 0 0\n";
  const Outcome uncovered =
      waymark({"evaluate", "--estimate", estimate, "--relations", (folder / "late.relations").string()});
  EXPECT_EQ(uncovered.exit_code, 1);
  EXPECT_THAT(uncovered.err, HasSubstr("none of 1 is covered"));
}

}  // namespace
}  // namespace waymark::system_test
