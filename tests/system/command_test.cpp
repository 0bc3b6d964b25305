// SPDX-License-Identifier: Apache-2.0
// needs plugins: csv, dgps, diagnostics, feature_map, held_out, imu, kitti, landmarks, odometry, plot, simulator
// needs plugins: tum
// What the command prints about itself, and what it prints for other programs.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <stdlib.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <functional>
#include <nlohmann/json.hpp>

#include "tests/system/small_robot.hpp"

namespace waymark::system_test {
namespace {

using testing::HasSubstr;
using testing::Not;

class Subcommand : public testing::TestWithParam<const char*> {};

TEST_P(Subcommand, ShowsAnExampleInItsHelp) {
  const Outcome outcome = waymark({GetParam(), "--help"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.out, HasSubstr(std::string("Example:\n  waymark ") + GetParam()));
  EXPECT_EQ(outcome.err, "");
}

INSTANTIATE_TEST_SUITE_P(Command, Subcommand,
                         testing::Values("run", "check", "plugins", "evaluate", "sweep", "schema", "new", "help"));

TEST(Command, HelpNamesEverySubcommand) {
  const Outcome outcome = waymark({"--help"});
  EXPECT_EQ(outcome.exit_code, 0);
  for (const char* name : {"run", "check", "plugins", "evaluate"})
    EXPECT_THAT(outcome.out, HasSubstr(std::string("\n  ") + name + " "));
}

TEST(Command, UnknownSubcommandIsOneErrorLine) {
  EXPECT_TRUE(reports_error(waymark({"fly"}), 2, {"fly", "run, check, doctor, calibrate, plugins, evaluate, map"}));
}

TEST(Command, NoSubcommandIsOneErrorLine) {
  EXPECT_TRUE(reports_error(waymark({}), 2, {"subcommand", "run, check, doctor, calibrate, plugins, evaluate, map"}));
}

TEST(Command, AMistypedSubcommandGetsTheNearestOne) {
  EXPECT_TRUE(reports_error(waymark({"rum", "robot.yaml"}), 2, {"\"rum\" is not expected; did you mean \"run\"?"}));
  EXPECT_TRUE(reports_error(waymark({"map", "inof", "hall.bt"}), 2, {"did you mean \"info\"?"}));
}

TEST(Command, AMistypedOptionGetsTheNearestOne) {
  EXPECT_TRUE(
      reports_error(waymark({"run", "robot.yaml", "--sed", "3"}), 2,
                    {"\"--sed\" is not expected; did you mean \"--set\" or \"--seed\"?", "see waymark help run"}));
  EXPECT_TRUE(reports_error(waymark({"evaluate", "--refrence=a.txt"}), 2, {"did you mean \"--reference\"?"}));
}

TEST(Command, PrintsItsVersion) {
  const Outcome outcome = waymark({"--version"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.out, testing::MatchesRegex("waymark [0-9]+\\.[0-9]+\\.[0-9]+\n"));
}

TEST(Help, IsThatOfTheSubcommand) {
  EXPECT_EQ(waymark({"help", "run"}).out, waymark({"run", "--help"}).out);
  EXPECT_EQ(waymark({"help", "map", "convert"}).out, waymark({"map", "convert", "--help"}).out);
  EXPECT_EQ(waymark({"help"}).out, waymark({"--help"}).out);
  EXPECT_TRUE(reports_error(waymark({"help", "rum"}), 2, {"no subcommand \"rum\"", "did you mean \"run\"?"}));
}

TEST(Help, TheManPageHasEverySubcommandAndOption) {
  const Outcome outcome = waymark({"help", "--man"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.out, HasSubstr(".TH WAYMARK 1"));
  EXPECT_THAT(outcome.out, HasSubstr("\n.SH map convert\n"));
  EXPECT_THAT(outcome.out, HasSubstr("\n.B \\-\\-log\\-level error|warning|info|debug\n"));
}

/// What the completion of bash offers for the words of a command line, of which the last one is being typed.
std::string offered_by_bash(const std::string& words) {
  const TemporaryFolder folder;
  write_text(folder / "completion", waymark({"help", "--completion", "bash"}).out);
  const std::string script = "source " + (folder / "completion").string() + "; COMP_WORDS=(" + words +
                             "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _waymark; echo \"${COMPREPLY[*]}\"";
  const std::string call = "bash -c '" + script + "' > " + (folder / "offered").string();
  EXPECT_EQ(std::system(call.c_str()), 0);
  return read_text(folder / "offered");
}

TEST(Help, BashCompletesSubcommandsOptionsAndTheirWords) {
  EXPECT_EQ(offered_by_bash("waymark ru"), "run\n");
  EXPECT_EQ(offered_by_bash("waymark map con"), "convert\n");
  EXPECT_EQ(offered_by_bash("waymark run robot.yaml --thr"), "--threads\n");
  EXPECT_EQ(offered_by_bash("waymark evaluate out/run --align se"), "se2 se3\n");
}

TEST(Help, ZshReadsItsCompletion) {
  if (std::system("command -v zsh > /dev/null") != 0) GTEST_SKIP() << "zsh is not installed";
  const TemporaryFolder folder;
  write_text(folder / "_waymark", waymark({"help", "--completion", "zsh"}).out);
  EXPECT_EQ(std::system(("zsh -n " + (folder / "_waymark").string()).c_str()), 0);
}

TEST(Plugins, ListsTheFieldsOfAPayload) {
  const Outcome outcome = waymark({"plugins", "GnssFix"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("latitude_deg [deg]: number, not known: NaN\n      latitude, WGS-84\n"));
}

TEST(Command, UnknownOptionIsOneErrorLine) {
  EXPECT_TRUE(reports_error(waymark({"run", "robot.yaml", "--particles", "3"}), 2, {"--particles"}));
}

TEST(Command, OptionOfTheWrongTypeIsOneErrorLine) {
  EXPECT_TRUE(reports_error(waymark({"run", "robot.yaml", "--threads", "many"}), 2, {"--threads", "many"}));
}

TEST(Command, MissingYamlIsOneErrorLine) {
  const TemporaryFolder folder;
  const std::string file = (folder / "robot.yaml").string();
  EXPECT_TRUE(reports_error(waymark({"run", file, "--out", (folder / "out").string()}), 1, {file}));
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

TEST(Command, OptionsThatMeanNothingTogetherAreAWrongCommandLine) {
  EXPECT_TRUE(reports_error(waymark({"evaluate"}), 2, {"nothing to score"}));
  EXPECT_TRUE(reports_error(waymark({"evaluate", "--estimate", "a.txt"}), 2, {"belong together"}));
  EXPECT_TRUE(
      reports_error(waymark({"evaluate", "--rpe-delta-m", "-1"}), 2, {"\"-1\" is not a finite number above 0"}));
  EXPECT_TRUE(
      reports_error(waymark({"run", "robot.yaml", "--until", "nan"}), 2, {"--until", "\"nan\" is not a finite"}));
  EXPECT_TRUE(reports_error(waymark({"run", "robot.yaml", "--seed", "-1"}), 2, {"--seed", "\"-1\" is not"}));
}

/// In the child: what is written to `descriptor` fails, as on a full disk or after `| head`.
std::function<void()> full(int descriptor) {
  return [descriptor] { ::dup2(::open("/dev/full", O_WRONLY), descriptor); };
}
std::function<void()> without_reader(int descriptor) {
  return [descriptor] {
    std::array<int, 2> ends{};
    if (::pipe(ends.data()) != 0) ::_exit(126);
    ::close(ends[0]);
    ::dup2(ends[1], descriptor);
  };
}

TEST(Command, ARunEndsAsUsualIfNobodyReadsWhatItSays) {
  for (const auto& broken : {full(STDERR_FILENO), without_reader(STDERR_FILENO)}) {
    const SmallRobot robot;
    robot.write();
    EXPECT_EQ(robot.command().in_child(broken).run().exit_code, 0);
    EXPECT_TRUE(robot.has_results(1000));
    EXPECT_EQ(Command({"run", "gone.yaml"}).in_child(broken).run().exit_code, 1);
  }
}

TEST(Command, WhatCannotBePrintedIsAnErrorButAClosedPipeIsNone) {
  EXPECT_TRUE(
      reports_error(Command({"plugins"}).in_child(full(STDOUT_FILENO)).run(), 1, {"standard output", "No space left"}));
  const Outcome cut = Command({"plugins"}).in_child(without_reader(STDOUT_FILENO)).run();
  EXPECT_EQ(cut.exit_code, 0);
  EXPECT_EQ(cut.err, "");
}

TEST(Plugins, ListsEveryKindAndWhereItWasFound) {
  const Outcome outcome = waymark({"plugins"});
  EXPECT_EQ(outcome.exit_code, 0);
  for (const char* plugin : {"odometry", "dgps", "imu", "feature_map", "csv", "kitti", "simulator", "tum", "landmarks",
                             "plot", "held_out", "diagnostics"}) {
    EXPECT_THAT(outcome.out, HasSubstr(fmt::format("/waymark_{}.so\n", plugin)));
  }
  for (const char* kind : {"sensor", "map", "source", "sink"})
    EXPECT_THAT(outcome.out, HasSubstr(std::string("\n") + kind));
  EXPECT_THAT(outcome.out, Not(HasSubstr("does not fit")));
}

TEST(Plugins, SaysWhatDoesNotFit) {
  const Outcome outcome = waymark({"plugins", "--path", WAYMARK_BAD_PLUGIN_DIR});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.out, HasSubstr("does not fit: "));
  EXPECT_THAT(outcome.out, HasSubstr("waymark_not_a_library.so"));
}

TEST(Check, ExplainsSensorsMapsAndValues) {
  const SmallRobot robot;
  const Outcome outcome = robot.check();
  EXPECT_EQ(outcome.exit_code, 0);
  for (const char* part : {"robot.yaml: valid", "plugin odometry", "plugin feature_map, from lidar",
                           "effective configuration", "particles: 5"}) {
    EXPECT_THAT(outcome.out, HasSubstr(part));
  }
  EXPECT_EQ(outcome.err, "");
}

/// A landmark map of nothing that was surveyed; the survey has a name that would clear a terminal.
std::vector<std::string> evaluation_of_a_hostile_survey(const TemporaryFolder& folder) {
  write_text(folder / "map.csv", "id,x_m,y_m,sightings\n1,50,50,99\n");
  write_text(folder / "survey.csv", "elm\x1b[2J\xff,1,2,0.1\n");
  return {
      "evaluate",         "--landmarks",   (folder / "map.csv").string(), "--survey", (folder / "survey.csv").string(),
      "--survey-columns", "name=0,x=1,y=2"};
}

TEST(Evaluate, NamesOfASurveyCannotCommandATerminal) {
  const TemporaryFolder folder;
  const int terminal = ::posix_openpt(O_RDWR | O_NOCTTY);
  ASSERT_TRUE(terminal >= 0 && ::grantpt(terminal) == 0 && ::unlockpt(terminal) == 0);
  const std::string name = ::ptsname(terminal);
  Command command(evaluation_of_a_hostile_survey(folder));
  command.in_child([&] { ::dup2(::open(name.c_str(), O_WRONLY | O_NOCTTY), STDOUT_FILENO); });
  EXPECT_EQ(command.run().exit_code, 0);
  std::array<char, 4096> seen{};
  const ssize_t count = ::read(terminal, seen.data(), seen.size());
  ::close(terminal);
  ASSERT_GT(count, 0);
  const std::string text(seen.data(), static_cast<std::size_t>(count));
  EXPECT_THAT(text, HasSubstr("elm\\x1b[2J"));
  EXPECT_THAT(text, Not(HasSubstr("\x1b")));
  // A file gets the text as it is.
  EXPECT_THAT(waymark(evaluation_of_a_hostile_survey(folder)).out, HasSubstr("elm\x1b[2J"));
}

TEST(Evaluate, JsonIsValidWhateverTheSurveyNames) {
  const TemporaryFolder folder;
  std::vector<std::string> arguments = evaluation_of_a_hostile_survey(folder);
  arguments.emplace_back("--json");
  const Outcome outcome = waymark(arguments);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(nlohmann::json::accept(outcome.out)) << outcome.out;
}

TEST(Evaluate, JsonIsValidAndNamesTheAlignment) {
  const SmallRobot robot;
  ASSERT_EQ(robot.run().exit_code, 0);
  const std::string path = (robot.out() / "path.txt").string();
  const Outcome outcome = waymark({"evaluate", "--estimate", path, "--reference", path, "--align", "se2", "--json"});
  EXPECT_EQ(outcome.exit_code, 0);
  ASSERT_TRUE(nlohmann::json::accept(outcome.out)) << outcome.out;
  EXPECT_THAT(outcome.out, HasSubstr("se2"));
}

}  // namespace
}  // namespace waymark::system_test
