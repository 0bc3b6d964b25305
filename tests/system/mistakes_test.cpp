// SPDX-License-Identifier: Apache-2.0
// needs plugins: compass, csv, dgps, diagnostics, imu, log, occupancy_grid, odometry, simulator, tum
//
// `waymark doctor` and the diagnosis of a run: part of the wall of mistakes (tests/results/mistakes.py has all of it).
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/system/outputs.hpp"

namespace waymark::system_test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr const char* kConfig = WAYMARK_SOURCE_DIR "/config/indoor.yaml";

TEST(Doctor, FindsNothingOnARobotWithoutAMistake) {
  const Outcome outcome = waymark({"doctor", kConfig});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("0 findings"));
  EXPECT_THAT(outcome.out, HasSubstr("agree"));
}

TEST(Diagnosis, OfARunIsInItsEventsAndItsDiagnostics) {
  const TemporaryFolder folder;
  const std::filesystem::path out = folder / "out";
  const Outcome run = waymark({"run", kConfig, "--out", out.string(), "--set", "sensors.wheels.track_m=0.8", "--set",
                               "filter.particles=1", "--set", "maps=[]"});
  EXPECT_THAT(run.err, HasSubstr("diagnosis: ")) << run.err;
  const nlohmann::json report = nlohmann::json::parse(read_text(out / "diagnostics.json"));
  ASSERT_FALSE(report.at("findings").empty());
  EXPECT_EQ(report.at("findings").at(0).at("sensors").at(0), "wheels");
  EXPECT_THAT(report.at("findings").at(0).at("change").get<std::string>(), HasSubstr("sensors.wheels.track_m: 0.5"));

  const Outcome without =
      waymark({"run", kConfig, "--out", out.string(), "--set", "sensors.wheels.track_m=0.8", "--set",
               "filter.particles=1", "--set", "maps=[]", "--set", "diagnosis.enabled=false"});
  EXPECT_THAT(without.err, Not(HasSubstr("diagnosis: ")));
  EXPECT_THAT(nlohmann::json::parse(read_text(out / "diagnostics.json")).at("findings"), IsEmpty());
}

}  // namespace
}  // namespace waymark::system_test
