// SPDX-License-Identifier: Apache-2.0
// needs plugins: csv, dgps, diagnostics, feature_map, held_out, landmarks, odometry, plot, simulator, tum
// The same log, configuration and seed give the same bytes, whatever the number of threads.
#include <gmock/gmock.h>

#include "tests/system/outputs.hpp"

namespace waymark::system_test {
namespace {

using testing::Contains;
using testing::Key;
using testing::Not;

using Files = std::map<std::string, std::string>;

/// Outputs of a run. config.yaml states the number of threads and is left out.
Files run(const std::string& config, std::vector<std::string> arguments) {
  const TemporaryFolder folder;
  arguments.insert(arguments.begin(), {"run", std::string(WAYMARK_SOURCE_DIR "/config/") + config, "--out",
                                       (folder / "out").string(), "--quiet"});
  const Outcome outcome = Command(std::move(arguments)).timeout(std::chrono::seconds(500)).run();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  return contents(folder / "out", {"config.yaml"});
}

/// Half a lap of the quickstart without the picture, which takes longer than the run.
Files short_run(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {"--set", "source.duration_s=25", "--set", "sinks.plot.enabled=false"});
  return run("quickstart.yaml", std::move(arguments));
}

TEST(Determinism, TwiceTheSameGivesTheSameBytes) {
  const Files first = short_run({"--threads", "2"});
  EXPECT_THAT(first, Contains(Key("trajectory.txt")));
  EXPECT_THAT(first, Contains(Key("landmarks.csv")));
  EXPECT_THAT(first, Contains(Key("diagnostics.json")));
  EXPECT_TRUE(same_bytes(first, short_run({"--threads", "2"})));
}

TEST(Determinism, OneTwoAndFourThreadsGiveTheSameBytes) {
  const Files one = short_run({"--threads", "1"});
  EXPECT_TRUE(same_bytes(one, short_run({"--threads", "2"})));
  EXPECT_TRUE(same_bytes(one, short_run({"--threads", "4"})));
}

TEST(Determinism, AnUnrelatedSinkChangesNothing) {
  Files with = run("quickstart.yaml", {"--set", "source.duration_s=25"});
  const Files without = short_run({});
  EXPECT_EQ(with.erase("map.png"), 1u);
  EXPECT_THAT(without, Not(Contains(Key("map.png"))));
  EXPECT_TRUE(same_bytes(with, without));
}

TEST(Determinism, AnotherSeedGivesOtherBytes) {
  Files one = short_run({"--seed", "1"});
  Files two = short_run({"--seed", "2"});
  EXPECT_NE(one["trajectory.txt"], two["trajectory.txt"]);
  EXPECT_EQ(one["reference.txt"], two["reference.txt"]) << "the filter's seed must not change the world";
}

TEST(Determinism, CarParkWithOneTwoAndFourThreads) {
  if (data_folder().empty()) GTEST_SKIP() << "WAYMARK_DATA is not set";
  const auto with = [](const char* threads) {
    return run("acfr_car_park.yaml",
               {"--threads", threads, "--set", "filter.particles=5", "--set", "sinks.plot.enabled=false"});
  };
  const Files one = with("1");
  EXPECT_TRUE(same_bytes(one, with("2")));
  EXPECT_TRUE(same_bytes(one, with("4")));
}

}  // namespace
}  // namespace waymark::system_test
