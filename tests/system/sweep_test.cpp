// SPDX-License-Identifier: Apache-2.0
// needs plugins: csv, diagnostics, dgps, feature_map, landmarks, odometry, tum
// `waymark sweep`: a study over values and seeds, its pages, what fails, and what goes on after an end.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/system/small_robot.hpp"

namespace waymark::system_test {
namespace {

using testing::HasSubstr;

/// The small robot with 2 and 4 particles and two seeds, scored against its own path with other seeds.
class SmallStudy {
 public:
  SmallStudy() {
    EXPECT_EQ(robot.run().exit_code, 0);
    path_ = (robot.out() / "path.txt").string();
    write_plan("[2, 4]");
  }

  void write_plan(const std::string& particles) const {
    write_text(plan(),
               fmt::format("title: Particles of the small robot\n"
                           "runs: [{{ config: robot.yaml, name: small }}]\n"
                           "vary: {{ filter.particles: {} }}\n"
                           "seeds: 2\n"
                           "evaluate: [--reference, '{}']\n"
                           "scores:\n"
                           "  - {{ name: RMS, path: evaluate.trajectory.ate_rms_m, at_most: 1 }}\n"
                           "  - {{ name: lost, path: diagnostics.health.lost_s, at_most: 0, judged_by: worst }}\n",
                           particles, path_));
  }

  std::filesystem::path plan() const { return robot.file("plan.yaml"); }
  std::filesystem::path out() const { return robot.file("study"); }
  Outcome sweep(std::vector<std::string> more = {}) const {
    std::vector<std::string> call{"sweep", plan().string(), "--out", out().string(), "--jobs", "2"};
    call.insert(call.end(), more.begin(), more.end());
    return waymark(call);
  }

  SmallRobot robot;

 private:
  std::string path_;
};

TEST(Sweep, RunsValuesAndSeedsAndWritesTables) {
  const SmallStudy study;
  const std::string page = study.robot.file("page.md").string();
  const Outcome outcome = study.sweep({"--page", page});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err << outcome.out;
  EXPECT_THAT(outcome.out, HasSubstr("small, particles 4"));
  EXPECT_THAT(outcome.err, HasSubstr("4 of 4 runs ended, 0 failed, 0 open"));
  EXPECT_THAT(read_text(page), HasSubstr("RMS, at most 1 by the median: reached by 2 of 2 rows"));
  EXPECT_THAT(read_text(study.out() / "study.html"), HasSubstr("<svg"));
  EXPECT_EQ(nlohmann::json::parse(read_text(study.out() / "study.json")).at("runs").size(), 4U);
  EXPECT_FALSE(std::filesystem::exists(study.out() / "running/000000"));
  // Nothing is run twice, and a value more adds its runs only.
  EXPECT_EQ(study.sweep({"--collect"}).out, outcome.out);
  study.write_plan("[2, 4, 6]");
  EXPECT_THAT(study.sweep({"--collect"}).err, HasSubstr("4 of 6 runs ended, 0 failed, 2 open"));
  EXPECT_EQ(study.sweep({"--task", "5"}).exit_code, 0);
  EXPECT_THAT(study.sweep({"--collect"}).err, HasSubstr("5 of 6 runs ended"));
  // The same again is the same to the last digit.
  const Outcome check = study.sweep({"--check", page.substr(0, page.size() - 2) + "json"});
  EXPECT_NE(check.exit_code, 0);
  EXPECT_THAT(check.err, HasSubstr("has no run \"small, particles 6\""));
  study.write_plan("[2, 4]");
  const Outcome same = study.sweep({"--check", page.substr(0, page.size() - 2) + "json"});
  EXPECT_EQ(same.exit_code, 0) << same.err;
  EXPECT_EQ(same.out, "2 of 2 rows tried; 0 values have changed\n");
}

TEST(Sweep, ListsWhatFailed) {
  const SmallStudy study;
  study.write_plan("[2, none]");
  const Outcome outcome = study.sweep();
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.out, HasSubstr("failed: task 2 (small, particles none, seed 1): waymark run: exit code 1"));
  EXPECT_THAT(outcome.err, HasSubstr("2 of 4 runs ended, 2 failed, 0 open"));
}

TEST(Sweep, RunsACommandForEachSeed) {
  const SmallStudy study;
  const auto write_command = [&](const std::string& body) {
    write_text(study.robot.file("score.sh"), "#!/bin/sh\n" + body);
    std::filesystem::permissions(study.robot.file("score.sh"), std::filesystem::perms::owner_all);
  };
  // The command runs the robot by itself, and prints how many rows its trajectory has.
  write_command(
      "\"$2\" run \"$(dirname \"$0\")/robot.yaml\" --quiet --out \"$3/it\" --set filter.particles=\"$4\" --seed \"$1\" "
      "&&\n"
      "echo \"{\\\"rows\\\": $(grep -vc '^#' \"$3/it/trajectory.txt\"), \\\"seed\\\": $1}\"\n");
  write_text(study.plan(),
             "title: A command\n"
             "runs: [{ name: rows, command: [./score.sh, '{seed}', '{waymark}', '{out}', '{particles}'] }]\n"
             "vary: { particles: [1, 2] }\n"
             "seeds: [3, 5]\n"
             "scores:\n"
             "  - { path: command.rows, at_least: 2, judged_by: worst }\n"
             "  - { path: command.seed, judged_by: mean }\n"
             "  - { path: run.cpu_s }\n");
  const std::string page = study.robot.file("page.md").string();
  const Outcome outcome = study.sweep({"--page", page});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err << outcome.out;
  EXPECT_THAT(read_text(page), HasSubstr("command.rows, at least 2 by every seed: reached by 2 of 2 rows"));
  EXPECT_THAT(read_text(page), HasSubstr("| rows, particles 2 | 2 | "));
  EXPECT_THAT(read_text(page), HasSubstr(" | 4 | "));  // the mean of the seeds
  const Outcome same = study.sweep({"--check", page.substr(0, page.size() - 2) + "json"});
  EXPECT_EQ(same.out, "2 of 2 rows tried; 0 values have changed\n") << same.err;
  write_command("echo no luck >&2\nexit 7\n");
  const Outcome failed = study.sweep({"--task", "1"});
  EXPECT_TRUE(reports_error(failed, 1, {"task 1", "score.sh: exit code 7: no luck"}));
}

TEST(Sweep, RefusesAPageThatAPersonWrote) {
  const SmallStudy study;
  write_text(study.robot.file("page.md"), "# My own\n");
  const Outcome outcome = study.sweep({"--page", study.robot.file("page.md").string()});
  EXPECT_TRUE(reports_error(outcome, 1, {"page.md", "not written by `waymark sweep`"}));
  EXPECT_EQ(read_text(study.robot.file("page.md")), "# My own\n");
}

TEST(Sweep, WithoutSlurmSaysSo) {
  const SmallStudy study;
  std::vector<std::string> call{"sweep", study.plan().string(), "--out", study.out().string(), "--slurm"};
  const Outcome outcome = Command(call).with_environment("PATH", "/nowhere").run();
  EXPECT_TRUE(reports_error(outcome, 1, {"sbatch"}));
  EXPECT_THAT(read_text(study.out() / "array.sh"), HasSubstr("#SBATCH --array=0-3\n"));
}

}  // namespace
}  // namespace waymark::system_test
