// SPDX-License-Identifier: Apache-2.0
// `waymark paper`, short: what it writes, and that its figures do not depend on how many courses run at the same time.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "system/command.hpp"

namespace waymark::system_test {
namespace {

using testing::HasSubstr;

const std::string kConfig = WAYMARK_SOURCE_DIR "/config/paper.yaml";

std::vector<std::string> paper(const std::filesystem::path& out, std::vector<std::string> more) {
  std::vector<std::string> arguments{"paper", kConfig, "--out", out.string(), "--set", "source.duration_s=8"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

TEST(Paper, WritesThePageItsFiguresAndAllNumbers) {
  const TemporaryFolder folder;
  const Outcome run = waymark(paper(folder / "out", {"--seeds", "2", "--noise", "1"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const std::string page = read_text(folder / "out/paper.md");
  for (int scenario = 1; scenario <= 4; ++scenario) {
    const std::string picture = "paper/scenario_" + std::to_string(scenario) + ".png";
    EXPECT_THAT(page, HasSubstr("](" + picture + ")"));
    EXPECT_THAT(read_text(folder / "out" / picture), testing::StartsWith("\x89PNG"));
  }
  const auto json = nlohmann::json::parse(read_text(folder / "out/paper.json"));
  ASSERT_EQ(json.at("trials").size(), 8u);
  // Eight seconds are enough to see the first poles, and much too short to lose the way.
  for (const auto& trial : json.at("trials")) {
    EXPECT_GT(trial.at("landmarks").get<int>(), 2);
    EXPECT_LT(trial.at("position_rms_m").get<double>(), 0.2);
    EXPECT_EQ(trial.at("wrong_associations").get<int>(), 0);
  }
}

TEST(Paper, ItsNumbersDoNotDependOnTheNumberOfJobs) {
  const TemporaryFolder folder;
  ASSERT_EQ(waymark(paper(folder / "one", {"--seeds", "3", "--noise", "2", "--jobs", "1"})).exit_code, 0);
  ASSERT_EQ(waymark(paper(folder / "three", {"--seeds", "3", "--noise", "2", "--jobs", "3"})).exit_code, 0);
  EXPECT_EQ(read_text(folder / "one/paper.json"), read_text(folder / "three/paper.json"));
}

TEST(Paper, AConfigWithoutTruthIsRefused) {
  const TemporaryFolder folder;
  const Outcome run = waymark({"paper", WAYMARK_SOURCE_DIR "/config/nowhere.yaml", "--out", (folder / "out").string()});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("nowhere.yaml"));
}

}  // namespace
}  // namespace waymark::system_test
