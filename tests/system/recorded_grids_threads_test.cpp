// SPDX-License-Identifier: Apache-2.0
// needs plugins: carmen, diagnostics, grid_map, occupancy_grid, odometry, plot, tum
// The beginning of recorded logs of CARMEN with a dense map: every place of config/carmen_sparse.yaml is mapped, and a
// real log gives the same bytes with any number of threads.
#include <gmock/gmock.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/system/outputs.hpp"

namespace waymark::system_test {
namespace {

/// Runs a configuration of a log of CARMEN without the picture.
void run_carmen(const std::string& name, const std::filesystem::path& out, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {"run", WAYMARK_SOURCE_DIR "/config/carmen_" + name + ".yaml", "--quiet", "--set",
                                       "sinks.plot.enabled=false", "--out", out.string()});
  const Outcome outcome = Command(std::move(arguments)).timeout(std::chrono::seconds(500)).run();
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
}

struct Place {
  std::string name, times, laser_x_m;

  friend void PrintTo(const Place& place, std::ostream* out) { *out << place.name; }
};

#if defined(__has_feature)
constexpr bool kThreadSanitizer = __has_feature(thread_sanitizer);
#else
constexpr bool kThreadSanitizer = false;
#endif

class SparseLogs : public testing::TestWithParam<Place> {
 protected:
  void SetUp() override {
    if (data_folder().empty()) GTEST_SKIP() << "WAYMARK_DATA is not set";
    if (kThreadSanitizer) GTEST_SKIP() << "one thread: nothing for the thread sanitizer";
  }
};

// Their scans are a metre apart: each one must be taken, and nearly each must fit.
TEST_P(SparseLogs, EveryScanIsMappedAndFits) {
  const TemporaryFolder folder;
  run_carmen("sparse", folder / "out",
             {"--until", "60", "--set", "variables.place=" + GetParam().name, "--set",
              "variables.times=" + GetParam().times, "--set", "variables.laser_x_m=" + GetParam().laser_x_m});
  const nlohmann::json report = nlohmann::json::parse(read_text(folder / "out/diagnostics.json"));
  const auto& lidar = report.at("sensors").at(1);
  ASSERT_EQ(lidar.at("name"), "lidar");
  const double scans = lidar.at("measurements");
  EXPECT_GE(scans, 10.0);
  EXPECT_GE(lidar.at("mapped").get<double>(), 0.9 * scans);
  const auto& figures = report.at("landmarks").at(0).at("figures");
  EXPECT_GE(figures.at("matches").get<double>(), 0.9 * (lidar.at("mapped").get<double>() - 1.0));
  EXPECT_EQ(report.at("run").at("bad_record_count"), 0);
}

INSTANTIATE_TEST_SUITE_P(Places, SparseLogs,
                         testing::Values(Place{"freiburg-101", "ipc", "-0.04"}, Place{"fhw", "ipc", "0"},
                                         Place{"belgioioso", "lines", "-0.04"}, Place{"csail", "lines", "0"},
                                         Place{"infinite-corridor", "lines", "0"},
                                         Place{"freiburg-campus", "lines", "-0.04"}),
                         [](const auto& place) {
                           std::string name = place.param.name;
                           std::ranges::replace(name, '-', '_');
                           return name;
                         });

TEST(RecordedLog, OneAndTwoThreadsGiveTheSameBytes) {
  if (data_folder().empty()) GTEST_SKIP() << "WAYMARK_DATA is not set";
  for (const std::string plugin : {"occupancy_grid", "octomap_grid"}) {
    const TemporaryFolder folder;
    for (const char* threads : {"1", "2"})
      run_carmen("intel", folder / threads,
                 {"--threads", threads, "--until", "100", "--set", "maps.building.plugin=" + plugin});
    const auto one = contents(folder / "1", {"config.yaml"});
    EXPECT_THAT(one, testing::Contains(testing::Key("building.pgm")));
    const nlohmann::json report = nlohmann::json::parse(one.at("diagnostics.json"));
    EXPECT_GT(report.at("run").at("resamplings").get<int>(), 0) << "or the test shows little";
    EXPECT_TRUE(same_bytes(one, contents(folder / "2", {"config.yaml"}))) << plugin;
  }
}

}  // namespace
}  // namespace waymark::system_test
