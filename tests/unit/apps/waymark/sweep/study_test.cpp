// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/sweep/study.hpp"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "apps/waymark/sweep/drift.hpp"
#include "apps/waymark/sweep/slurm.hpp"
#include "apps/waymark/sweep/study_page.hpp"
#include "temporary_folder.hpp"
#include "waymark/base/error.hpp"

namespace waymark::sweep {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(NumberAt, FollowsNamesIndicesAndSensors) {
  const auto document = nlohmann::json::parse(
      R"({"evaluate": {"rms_m": 0.5, "innovations": [{"sensor": "gps", "nis": 2.5}], "missed": [3, 4]}, "none": null})");
  EXPECT_EQ(number_at(document, "evaluate.rms_m"), 0.5);
  EXPECT_EQ(number_at(document, "evaluate.innovations.gps.nis"), 2.5);
  EXPECT_EQ(number_at(document, "evaluate.innovations.0.nis"), 2.5);
  EXPECT_EQ(number_at(document, "evaluate.missed"), 2.0);  // how many
  EXPECT_EQ(number_at(document, "evaluate.innovations.1.nis"), std::nullopt);
  EXPECT_EQ(number_at(document, "none"), std::nullopt);
  EXPECT_EQ(number_at(document, "evaluate.rms_m.deeper"), std::nullopt);
}

TEST(ArrayOfTasks, FoldsNeighbours) {
  EXPECT_EQ(array_of({{0, 0, 1}, {1, 0, 2}, {2, 0, 3}, {7, 0, 1}}), "0-2,7");
  EXPECT_EQ(array_of({{4, 0, 1}}), "4");
}

/// A study whose program is a script instead of waymark: its "run" leaves the seed, its "evaluate" prints it.
class ScriptedStudy : public testing::Test {
 protected:
  ScriptedStudy() {
    script_of(R"(if [ "$1" = run ]; then
  [ "$6" = 13 ] && { echo "waymark: error: unlucky" >&2; exit 1; }
  mkdir -p "$4" && echo "$6" > "$4/seed" && echo ran >> )" +
              (folder_ / "calls").string() + R"(
else
  echo "{\"error\": $(cat "$2/seed")}"
fi
)");
    plan_.file = folder_ / "plan.yaml";
    plan_.title = "Seeds | dots";
    std::ofstream(folder_ / "robot.yaml") << "sensors: []\n";
    plan_.variants = {{"first", folder_ / "robot.yaml", {}, {}}};
    plan_.seeds = {1, 2, 6};
    plan_.scores = {{"error [m]", "evaluate.error", 2.5, std::nullopt, Score::Judged::by_median}};
  }

  void script_of(const std::string& body) const {
    const std::filesystem::path script = folder_ / "program";
    std::ofstream(script) << "#!/bin/sh\n" << body;
    std::filesystem::permissions(script, std::filesystem::perms::owner_all);
  }
  Study study(const std::string& version = "1.0.0") const {
    return {plan_, folder_ / "study", folder_ / "program", version};
  }
  static void run_open(const Study& study) {
    for (const Task& task : study.open_tasks()) study.run(task);
  }
  int calls() const {
    std::ifstream file(folder_ / "calls");
    int count = 0;
    for (std::string line; std::getline(file, line);) ++count;
    return count;
  }

  test::TemporaryFolder folder_;
  Plan plan_;
};

TEST_F(ScriptedStudy, SummarizesOverTheSeeds) {
  const Study study = this->study();
  run_open(study);
  const Summary summary = summarize(study);
  ASSERT_EQ(summary.lines.size(), 1U);
  const Cell& cell = summary.lines[0].cells[0];
  EXPECT_EQ(cell.min, 1.0);
  EXPECT_EQ(cell.median, 2.0);
  EXPECT_EQ(cell.max, 6.0);
  EXPECT_EQ(cell.reached, true);
  plan_.scores[0].judged = Score::Judged::by_worst;
  EXPECT_EQ(summarize(this->study()).lines[0].cells[0].reached, false);
}

TEST_F(ScriptedStudy, GoesOnWhereItWas) {
  study().run(plan_.tasks()[1]);
  EXPECT_EQ(study().open_tasks().size(), 2U);
  run_open(study());
  EXPECT_EQ(calls(), 3);
  run_open(study());
  EXPECT_EQ(calls(), 3);
}

TEST_F(ScriptedStudy, WhatChangedIsRunAgain) {
  run_open(study());
  plan_.seeds = {1, 2, 7};
  ASSERT_EQ(study().open_tasks().size(), 1U);
  EXPECT_EQ(study().open_tasks()[0].seed, 7U);
  EXPECT_EQ(study("1.0.1").open_tasks().size(), 3U);
  std::ofstream(folder_ / "robot.yaml") << "sensors: [ ]\n";
  EXPECT_EQ(study().open_tasks().size(), 3U);
}

TEST_F(ScriptedStudy, ListsWhatFailedAndKeepsItOpen) {
  plan_.seeds = {1, 13};
  const Study study = this->study();
  run_open(study);
  const Summary summary = summarize(study);
  ASSERT_EQ(summary.failures.size(), 1U);
  EXPECT_EQ(summary.failures[0].error, "waymark run: exit code 1: waymark: error: unlucky");
  EXPECT_EQ(summary.lines[0].ended, 1U);
  ASSERT_EQ(study.open_tasks().size(), 1U);
  EXPECT_EQ(study.open_tasks()[0].seed, 13U);
  EXPECT_THAT(to_text(study, summary), HasSubstr("failed: task 1 (first, seed 13)"));
}

TEST_F(ScriptedStudy, PagesHaveTableMarksAndCommand) {
  const Study study = this->study();
  run_open(study);
  const Summary summary = summarize(study);
  const std::string page = to_markdown(study, summary, "plan.yaml");
  EXPECT_THAT(page, HasSubstr("# Seeds | dots\n\nMade by\n\n    waymark sweep plan.yaml\n"));
  EXPECT_THAT(page, HasSubstr("| first | 3 | 1 / 2 / 6 |\n"));
  EXPECT_THAT(page, HasSubstr("error [m], at most 2.5 by the median: reached by 1 of 1 rows\n"));
  const std::string html = to_html(study, summary, "plan.yaml");
  EXPECT_THAT(html, HasSubstr("<td class=\"reached\">1 / 2 / 6</td>"));
  EXPECT_THAT(html, HasSubstr("<circle"));
}

TEST_F(ScriptedStudy, FillsItsPartOfAPageOfAPerson) {
  const Study study = this->study();
  run_open(study);
  const Summary summary = summarize(study);
  const std::string page = "# Mine\n\n<!-- study: plan -->\nold\n<!-- end of study -->\n\nMy thoughts.\n";
  const std::optional<std::string> filled = inserted(page, study, summary, "plan.yaml");
  ASSERT_TRUE(filled);
  EXPECT_THAT(*filled, testing::StartsWith("# Mine\n\n<!-- study: plan -->\nMade by\n\n    waymark sweep plan.yaml\n"));
  EXPECT_THAT(*filled, HasSubstr("| first | 3 | 1 / 2 / 6 |\n"));
  EXPECT_THAT(*filled, testing::EndsWith("<!-- end of study -->\n\nMy thoughts.\n"));
  EXPECT_THAT(*filled, testing::Not(HasSubstr("old")));
  EXPECT_EQ(inserted(*filled, study, summary, "plan.yaml"), filled);
  EXPECT_EQ(inserted("# Mine\n\n<!-- study: another -->\n<!-- end of study -->\n", study, summary, ""), std::nullopt);
  EXPECT_EQ(inserted("# Mine\n\n<!-- study: plan -->\nno end\n", study, summary, ""), std::nullopt);
}

TEST_F(ScriptedStudy, RowsHaveOptionsOfTheirOwn) {
  script_of(R"sh(if [ "$1" = run ]; then
  mkdir -p "$4" && echo "$*" | sed 's/.*--set place=//' > "$4/place"
else
  echo "{\"error\": $#, \"here\": $([ "$(cat "$2/place")" = "$2/x" ] && echo 1 || echo 0)
}"
fi
)sh");
  plan_.evaluate = {"--align", "se2"};
  plan_.variants.push_back(plan_.variants.front());
  plan_.variants.back().name = "with more";
  plan_.variants.back().evaluate = {"--outage=1:2"};
  for (Variant& variant : plan_.variants) variant.overrides = {"place={out}/x"};
  plan_.scores.push_back({"here", "evaluate.here", std::nullopt, std::nullopt, Score::Judged::by_median});
  const Study study = this->study();
  run_open(study);
  const Summary summary = summarize(study);
  ASSERT_EQ(summary.lines.size(), 2U);
  EXPECT_EQ(summary.lines[0].cells[0].median, 5.0);  // evaluate FOLDER --json --align se2
  EXPECT_EQ(summary.lines[1].cells[0].median, 6.0);
  EXPECT_EQ(summary.lines[0].cells[1].median, 1.0);  // {out} is the folder of the run
}

TEST_F(ScriptedStudy, FindsWhatHasDrifted) {
  {
    const Study study = this->study();
    run_open(study);
    std::ofstream(folder_ / "earlier.json") << to_json(study, "plan.yaml");
  }
  std::size_t ended = 0;
  EXPECT_TRUE(find_drift(study(), folder_ / "earlier.json", [&](std::size_t count) { ended = count; }).empty());
  EXPECT_EQ(ended, 1U);
  script_of("[ \"$1\" = run ] || echo '{\"error\": 1.5}'\n");
  const std::vector<Drift> drifts = find_drift(study(), folder_ / "earlier.json", [](std::size_t) {});
  ASSERT_EQ(drifts.size(), 1U);
  EXPECT_EQ(drifts[0].before, "1");
  EXPECT_EQ(drifts[0].now, "1.5");
  EXPECT_THROW(find_drift(study(), folder_ / "nothing.json", [](std::size_t) {}), Error);
}

/// A study whose only row is a command: a script beside the program.
class CommandStudy : public ScriptedStudy {
 protected:
  CommandStudy() {
    command_of(
        "echo 'first line'\necho \"{\\\"found\\\": $1, \\\"named\\\": [{\\\"name\\\": \\\"gps\\\", \\\"count\\\": "
        "2}]}\"\n");
    plan_.variants = {{"a command", {}, {}, {}, {command(), "{seed}", "{out}", "{waymark}"}}};
    plan_.scores = {{"found", "command.found", std::nullopt, 2.5, Score::Judged::by_mean},
                    {"named", "command.named.gps.count", std::nullopt, std::nullopt, Score::Judged::by_median},
                    {"missing", "command.missing", std::nullopt, std::nullopt, Score::Judged::by_median},
                    {"exit code", "run.exit_code", std::nullopt, std::nullopt, Score::Judged::by_median}};
  }
  std::string command() const { return (folder_ / "score.sh").string(); }
  void command_of(const std::string& body) const {
    std::ofstream(command()) << "#!/bin/sh\n" << body;
    std::filesystem::permissions(command(), std::filesystem::perms::owner_all);
  }
};

TEST_F(CommandStudy, TakesScoresFromTheLastLineOfACommand) {
  const Study study = this->study();
  run_open(study);
  const Summary summary = summarize(study);
  ASSERT_TRUE(summary.failures.empty()) << summary.failures[0].error;
  const Line& line = summary.lines.at(0);
  EXPECT_THAT(line.cells[0].values, testing::ElementsAre(1.0, 2.0, 6.0));
  EXPECT_EQ(line.cells[1].median, 2.0);
  EXPECT_TRUE(line.cells[2].values.empty());
  EXPECT_EQ(line.cells[3].max, 0.0);
  // Judged by the mean: 3, where the median is 2.
  EXPECT_EQ(line.cells[0].reached, true);
  const std::string page = to_markdown(study, summary, "plan.yaml");
  EXPECT_THAT(page, HasSubstr("| run | seeds | found, mean | named |"));
  EXPECT_THAT(page, HasSubstr("| a command | 3 | 3 | 2 | – | 0 |\n"));
  EXPECT_THAT(page, HasSubstr("found, at least 2.5 by the mean: reached by 1 of 1 rows\n"));
}

TEST_F(CommandStudy, ASingleRowWithManyScoresStandsUpright) {
  for (int i = 0; i < 5; ++i) plan_.scores.push_back(plan_.scores.front());
  const Study study = this->study();
  run_open(study);
  const std::string upright = "| run | a command |\n|---|---|\n| seeds | 3 |\n| found, mean | 3 |\n";
  EXPECT_THAT(to_markdown(study, summarize(study), "plan.yaml"), HasSubstr(upright));
  plan_.variants.push_back(plan_.variants.front());
  plan_.variants.back().name = "the same";
  EXPECT_THAT(to_markdown(this->study(), summarize(this->study()), "plan.yaml"), HasSubstr("| run | seeds | found,"));
}

TEST_F(CommandStudy, GivesACommandSeedFolderAndProgram) {
  command_of("[ -d \"$2\" ] && echo kept > \"$2/file\" && [ -x \"$3\" ] && echo \"{\\\"found\\\": 4}\"\n");
  const Study study = this->study();
  EXPECT_EQ(study.run(plan_.tasks()[0]).values.at(0), 4.0);
  EXPECT_FALSE(std::filesystem::exists(study.folder() / "running/000000"));
}

TEST_F(CommandStudy, FailsWithAReason) {
  const auto error = [&] { return study().run(plan_.tasks()[0]).error; };
  command_of("echo '{\"found\": 1}'\necho first >&2\necho 'no such log' >&2\nexit 3\n");
  EXPECT_EQ(error(), "score.sh: exit code 3: no such log");
  command_of("echo '{\"found\": 1}'\necho done\n");
  EXPECT_EQ(error(), "score.sh: the last line of its output is \"done\": a JSON object is expected");
  command_of("echo 4\n");
  EXPECT_THAT(error(), HasSubstr("a JSON object is expected"));
  plan_.variants[0].command = {"no-such-program-anywhere"};
  EXPECT_THAT(error(), HasSubstr("no-such-program-anywhere: exit code 127"));
}

TEST_F(CommandStudy, LooksUpAProgramInThePath) {
  plan_.variants[0].command = {"echo", "{\"found\": {seed}}"};
  plan_.scores.resize(1);
  const Study study = this->study();
  run_open(study);
  EXPECT_THAT(summarize(study).lines[0].cells[0].values, testing::ElementsAre(1.0, 2.0, 6.0));
}

TEST_F(CommandStudy, AnotherCommandOrProgramFileIsRunAgain) {
  run_open(study());
  EXPECT_TRUE(study().open_tasks().empty());
  plan_.variants[0].command.emplace_back("--more");
  EXPECT_EQ(study().open_tasks().size(), 3U);
  plan_.variants[0].command.pop_back();
  EXPECT_TRUE(study().open_tasks().empty());
  command_of("echo '{\"found\": 1}'\n");
  EXPECT_EQ(study().open_tasks().size(), 3U);
}

TEST_F(CommandStudy, DriftLeavesOutTimes) {
  command_of("echo '{\"found\": 1, \"cpu_s\": 2}'\n");
  plan_.scores.push_back({"CPU [s]", "command.cpu_s", std::nullopt, std::nullopt, Score::Judged::by_median});
  run_open(study());
  std::ofstream(folder_ / "earlier.json") << to_json(study(), "plan.yaml");
  command_of("echo '{\"found\": 1, \"cpu_s\": 3}'\n");
  EXPECT_TRUE(find_drift(study(), folder_ / "earlier.json", [](std::size_t) {}).empty());
}

TEST_F(ScriptedStudy, TheArrayScriptNamesPlanFolderAndTasks) {
  plan_.threads = 2;
  const Study study = this->study();
  const std::string script = array_script(study, "/opt/way mark", study.open_tasks(), 4);
  EXPECT_THAT(script, HasSubstr("#SBATCH --array=0-2%4\n#SBATCH --cpus-per-task=2\n"));
  EXPECT_THAT(script, HasSubstr("exec '/opt/way mark' sweep '" + (folder_ / "plan.yaml").string() + "' --out '"));
  EXPECT_THAT(script, Not(HasSubstr("  ")));
}

}  // namespace
}  // namespace waymark::sweep
