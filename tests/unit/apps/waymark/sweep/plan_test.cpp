// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/sweep/plan.hpp"

#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "temporary_folder.hpp"
#include "waymark/base/error.hpp"

namespace waymark::sweep {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

class PlanFile : public testing::Test {
 protected:
  PlanFile() { write("robot.yaml", "sensors: []\n"); }

  void write(const std::string& name, const std::string& text) const { std::ofstream(folder_ / name) << text; }
  Plan read(const std::string& text) const {
    write("plan.yaml", text);
    return Plan::read(folder_ / "plan.yaml");
  }

  test::TemporaryFolder folder_;
};

TEST_F(PlanFile, TasksAreEveryVariantWithEverySeed) {
  const Plan plan = read(
      "title: Particles\n"
      "runs: [{ config: robot.yaml, set: [sensors.gps.enabled=false] }]\n"
      "vary: { filter.particles: [10, 25] }\n"
      "seeds: [3, 7]\n"
      "scores: [{ path: run.cpu_s }]\n");
  ASSERT_EQ(plan.variants.size(), 2U);
  EXPECT_EQ(plan.variants[1].name, "robot, particles 25");
  EXPECT_THAT(plan.variants[1].overrides, ElementsAre("sensors.gps.enabled=false", "filter.particles=25"));
  const std::vector<Task> tasks = plan.tasks();
  ASSERT_EQ(tasks.size(), 4U);
  EXPECT_EQ(tasks[3].number, 3U);
  EXPECT_EQ(tasks[3].variant, 1U);
  EXPECT_EQ(tasks[3].seed, 7U);
}

TEST_F(PlanFile, EveryCombinationOfValuesIsAVariant) {
  const Plan plan = read(
      "title: t\nruns: [{ config: robot.yaml, name: a }, { config: robot.yaml, name: b }]\n"
      "vary: { x.p: [1, 2, 3], x.q: [on, off] }\nscores: [{ path: run.cpu_s }]\n");
  EXPECT_EQ(plan.variants.size(), 12U);
  EXPECT_EQ(plan.variants.back().name, "b, p 3, q off");
  EXPECT_EQ(plan.seeds.size(), 10U);
}

TEST_F(PlanFile, MistakesAreErrorsWithTheirPlace) {
  const std::string rest = "title: t\nscores: [{ path: run.cpu_s }]\n";
  const auto fails = [&](const std::string& text, const std::string& message) {
    EXPECT_THAT([&] { read(text); }, ThrowsMessage<ConfigError>(HasSubstr(message))) << text;
  };
  fails(rest + "runs: [{ config: nothing.yaml }]\n", "nothing.yaml\" is no file");
  fails(rest + "runs: []\n", "at least one configuration");
  fails(rest + "runs: [{ config: robot.yaml, set: [filter.particles] }]\n", "key=value is expected");
  fails(rest + "runs: [{ config: robot.yaml }, { config: robot.yaml }]\n", "would be called \"robot\"");
  fails(rest + "runs: [{ config: robot.yaml }]\nseeds: [1, 1]\n", "a seed is given twice");
  fails(rest + "runs: [{ config: robot.yaml }]\nseeds: 1.5\n", "1.5");
  fails(rest + "runs: [{ config: robot.yaml }]\nsedes: 3\n", "seeds");
}

TEST_F(PlanFile, ARowHasOptionsOfItsOwn) {
  const Plan plan = read(
      "title: t\nevaluate: [--align, se2]\nruns: [{ config: robot.yaml, evaluate: [--min-sightings, 5] }]\n"
      "scores: [{ path: run.cpu_s }]\n");
  EXPECT_THAT(plan.evaluate, ElementsAre("--align", "se2"));
  EXPECT_THAT(plan.variants[0].evaluate, ElementsAre("--min-sightings", "5"));
}

TEST_F(PlanFile, ARowCanBeACommand) {
  write("score.py", "");
  const Plan plan = read(
      "title: t\nruns: [{ command: [./score.py, --seed, '{seed}', '--set=filter.particles={filter.particles}'] },\n"
      "  { name: from the path, command: [echo, '{filter.particles}'] }, { config: robot.yaml }]\n"
      "vary: { filter.particles: [1, 5] }\nscores: [{ path: command.found, judged_by: mean }]\n");
  ASSERT_EQ(plan.variants.size(), 6U);
  EXPECT_EQ(plan.variants[1].name, "score, particles 5");
  EXPECT_THAT(plan.variants[1].command,
              ElementsAre((folder_ / "score.py").string(), "--seed", "{seed}", "--set=filter.particles=5"));
  EXPECT_THAT(plan.variants[1].overrides, testing::IsEmpty());
  EXPECT_THAT(plan.variants[2].command, ElementsAre("echo", "1"));  // looked up in PATH
  EXPECT_THAT(plan.variants[5].command, testing::IsEmpty());
  EXPECT_THAT(plan.variants[5].overrides, ElementsAre("filter.particles=5"));
  EXPECT_EQ(plan.scores[0].judged, Score::Judged::by_mean);
}

TEST_F(PlanFile, MistakesOfCommandsAreErrorsWithTheirPlace) {
  const auto fails = [&](const std::string& row, const std::string& message) {
    const std::string text = "title: t\nscores: [{ path: command.found }]\nruns:\n  - " + row + "\n";
    EXPECT_THAT([&] { read(text); },
                ThrowsMessage<ConfigError>(testing::AllOf(HasSubstr("plan.yaml:"), HasSubstr(message))))
        << text;
  };
  fails("{ command: [echo], config: robot.yaml }", "or a `command`, not both");
  fails("{ command: [echo], set: [a=1] }", "plan.yaml:4:29: runs[0].set: a row has a `config`");
  fails("{ command: [echo], evaluate: [--align, se2] }", "or a `command`, not both");
  fails("{ command: [] }", "a program and its arguments are expected");
  fails("{ command: [./nothing.py] }", "nothing.py\" is no file: a program is expected");
  fails("{ command: [echo] }\nevaluate: [--align, se2]", "plan.yaml:5:11: evaluate: every row is a command");
  fails("{ command: [echo, 1] }\nvary: { p: [1, 2] }", "plan.yaml:5:12: vary.p: the command of \"echo\" has no {p}");
}

/// A page cites its plan, and a plan names its page: the plans of the repository can be read, and their pages have room
/// for the table.
TEST(Plans, OfTheResultsAreReadAndHaveAPage) {
  ::setenv("WAYMARK_DATA", "recordings", 0);  // plans name them, nothing is read
  const std::filesystem::path repository = WAYMARK_SOURCE_DIR;
  std::size_t plans = 0;
  for (const auto& entry : std::filesystem::directory_iterator(repository / "tests/results/plans")) {
    ++plans;
    EXPECT_NO_THROW(Plan::read(entry.path())) << entry.path();
    std::ifstream file(entry.path());
    std::string command;
    std::getline(file, command);
    const std::string before = "# waymark sweep tests/results/plans/" + entry.path().filename().string();
    ASSERT_THAT(command, testing::StartsWith(before));
    const std::size_t page = command.find(" --page ");
    if (page == std::string::npos) continue;  // its table is part of a text
    std::ifstream stream(repository / command.substr(page + 8));
    const std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
    EXPECT_THAT(text, HasSubstr(command.substr(2))) << "the page has no table by this command";
  }
  EXPECT_GE(plans, 38U);
}

}  // namespace
}  // namespace waymark::sweep
