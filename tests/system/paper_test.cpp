// SPDX-License-Identifier: Apache-2.0
// needs plugins: dgps, diagnostics, feature_map, landmarks, odometry, plot, simulator, tum
// `waymark paper`, short: what it writes, and that its figures do not depend on how many courses run at the same time.
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "system/command.hpp"

namespace waymark::system_test {
namespace {

using testing::HasSubstr;

const std::string kConfig = WAYMARK_SOURCE_DIR "/config/paper.yaml";
const std::string kPublished = WAYMARK_SOURCE_DIR "/config/paper_literal.yaml";

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
    for (const std::string filter : {"", "published_"}) {
      const std::string picture = "paper/" + filter + "scenario_" + std::to_string(scenario) + ".png";
      EXPECT_THAT(page, HasSubstr("](" + picture + ")"));
      EXPECT_THAT(read_text(folder / "out" / picture), testing::StartsWith("\x89PNG"));
    }
  }
  EXPECT_THAT(page, HasSubstr("## Side by side"));
  const auto json = nlohmann::json::parse(read_text(folder / "out/paper.json"));
  ASSERT_EQ(json.at("trials").size(), 16u) << "four scenarios, ours and as published";
  // Eight seconds are enough to see the first poles, and much too short to lose the way.
  for (const auto& trial : json.at("trials")) {
    EXPECT_GT(trial.at("landmarks").get<int>(), 2);
    EXPECT_LT(trial.at("position_rms_m").get<double>(), 0.2);
    EXPECT_EQ(trial.at("wrong_associations").get<int>(), 0);
  }
}

TEST(Paper, TheAlgorithmAsPublishedGetsTheSameMeasurements) {
  const auto measured = [](const std::string& file) {
    const std::string text = read_text(file);
    const std::size_t begin = text.find("\nsource:");
    return text.substr(begin, text.find("\nmaps:") - begin);
  };
  EXPECT_EQ(measured(kConfig), measured(kPublished));
}

// docs/results/paper.md has 30 seeds. The figures are the paper's own: with radius and signature the map is right with
// one particle; on the position alone whole colonnades are drawn twice, which more particles make rarer.
TEST(Paper, TheAlgorithmAsPublishedFailsAsThePaperSays) {
  constexpr int kSeeds = 8;
  const TemporaryFolder folder;
  const Outcome run = Command({"paper", kPublished, "--seeds", std::to_string(kSeeds), "--noise", "1", "--out",
                               (folder / "out").string()})
                          .timeout(std::chrono::seconds(600))
                          .run();
  ASSERT_EQ(run.exit_code, 0) << run.err;
  std::map<int, int> exact;
  std::vector<int> landmarks;  // of scenario 2
  int twelve = 0;              // of scenario 1
  const auto json = nlohmann::json::parse(read_text(folder / "out/paper.json"));
  ASSERT_EQ(json.at("trials").size(), 4u * kSeeds);
  for (const auto& trial : json.at("trials")) {
    const int scenario = trial.at("scenario");
    exact[scenario] += trial.at("exact_map").get<bool>() ? 1 : 0;
    if (scenario == 1) twelve += trial.at("landmarks").get<int>() == 12 ? 1 : 0;
    if (scenario == 2) landmarks.push_back(trial.at("landmarks"));
  }
  EXPECT_GE(exact[3], exact[1]);
  EXPECT_GT(exact[1], exact[4]);
  EXPECT_GT(exact[4], exact[2]);
  EXPECT_GE(twelve, 6) << "scenario 1 ends with the twelve cylinders";
  std::ranges::sort(landmarks);
  EXPECT_GE(landmarks[kSeeds / 2], 20) << "scenario 2 draws the colonnades twice on most seeds";
}

TEST(Paper, KeepsAPageThatAPersonWrote) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "out");
  std::ofstream(folder / "out/paper.md") << "# My results\n";
  const Outcome run = waymark(paper(folder / "out", {"--seeds", "1", "--noise", "1"}));
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr((folder / "out/paper.md").string()));
  EXPECT_EQ(read_text(folder / "out/paper.md"), "# My results\n");
}

TEST(Paper, ReplacesAPageOfItsOwn) {
  const TemporaryFolder folder;
  for (const std::string seeds : {"1", "2"})
    ASSERT_EQ(waymark(paper(folder / "out", {"--seeds", seeds, "--noise", "1"})).exit_code, 0);
  EXPECT_THAT(read_text(folder / "out/paper.md"), HasSubstr("--seeds 2"));
}

TEST(Paper, ItsNumbersDoNotDependOnTheNumberOfJobs) {
  const TemporaryFolder folder;
  ASSERT_EQ(waymark(paper(folder / "one", {"--seeds", "3", "--noise", "2", "--jobs", "1"})).exit_code, 0);
  ASSERT_EQ(waymark(paper(folder / "three", {"--seeds", "3", "--noise", "2", "--jobs", "3"})).exit_code, 0);
  EXPECT_EQ(read_text(folder / "one/paper.json"), read_text(folder / "three/paper.json"));
}

TEST(Paper, ShowsTheOutagesOfTheEkf) {
  const TemporaryFolder folder;
  const Outcome run = waymark({"paper", WAYMARK_SOURCE_DIR "/config/paper_outages.yaml", "--experiment", "outages",
                               "--seeds", "3", "--out", (folder / "out").string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const std::string page = read_text(folder / "out/outages.md");
  for (const std::string picture : {"paper/fig_3_1.png", "paper/fig_3_2.png"}) {
    EXPECT_THAT(page, HasSubstr("](" + picture + ")"));
    EXPECT_THAT(read_text(folder / "out" / picture), testing::StartsWith("\x89PNG"));
  }
  const auto json = nlohmann::json::parse(read_text(folder / "out/outages.json"));
  ASSERT_EQ(json.at("trials").size(), 3u);
  for (const auto& trial : json.at("trials")) {
    ASSERT_EQ(trial.at("outages").size(), 4u) << "as many as in the YAML";
    for (const auto& outage : trial.at("outages")) {
      EXPECT_GT(outage.at("sigma_end_m").get<double>(), 0.3) << "an outage makes the pose uncertain";
      EXPECT_LT(outage.at("error_end_sigma").get<double>(), 8.0);
      EXPECT_GT(outage.at("step_m").get<double>(), 0.0);
    }
  }
}

TEST(Paper, MeetsSlamWithEveryGps) {
  const TemporaryFolder folder;
  const Outcome run = waymark({"paper", WAYMARK_SOURCE_DIR "/config/paper_sawtooth.yaml", "--experiment", "sawtooth",
                               "--seeds", "1", "--out", (folder / "out").string(), "--set", "source.duration_s=8"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = nlohmann::json::parse(read_text(folder / "out/sawtooth.json"));
  // Five rates and four errors and no GPS at all; three filters with one particle and with 25.
  ASSERT_EQ(json.at("trials").size(), 21u * 6u);
  const auto rms = [&](double rate, double error) {
    for (const auto& trial : json.at("trials")) {
      if (trial.at("gps_rate_hz") == rate && trial.at("gps_correlated_m") == error)
        return trial.at("position_rms_m").get<double>();
    }
    return -1.0;
  };
  EXPECT_LT(rms(0.0, 0.0), 0.1);
  EXPECT_GT(rms(5.0, 2.0), 2.0 * rms(0.0, 0.0)) << "a GPS that errs by metres pulls the paper's filter away";
  EXPECT_THAT(read_text(folder / "out/sawtooth.md"), HasSubstr("| 0.2 Hz |"));
}

TEST(Paper, AnExperimentRefusesNoiseThatItCannotTake) {
  const Outcome run = waymark({"paper", "--experiment", "outages", "--noise", "1"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("--noise"));
}

TEST(Paper, AConfigWithoutTruthIsRefused) {
  const TemporaryFolder folder;
  const Outcome run = waymark({"paper", WAYMARK_SOURCE_DIR "/config/nowhere.yaml", "--out", (folder / "out").string()});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("nowhere.yaml"));
}

}  // namespace
}  // namespace waymark::system_test
