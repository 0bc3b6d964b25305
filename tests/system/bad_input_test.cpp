// SPDX-License-Identifier: Apache-2.0
// needs plugins: csv, dgps, diagnostics, feature_map, landmarks, odometry, tum
// Logs that are not as they should be: one clear line, non-zero exit, nothing lost.
#include <gmock/gmock.h>
#include <zlib.h>

#include <nlohmann/json.hpp>

#include "tests/system/small_robot.hpp"

namespace waymark::system_test {
namespace {

using testing::HasSubstr;
using testing::SizeIs;

/// Line `line` of a file (from 1, as an editor counts) as an element of its list of lines.
std::string& at_line(std::vector<std::string>& lines, std::size_t line) { return lines.at(line - 1); }

void write_gzip(const std::filesystem::path& file, const std::vector<std::string>& lines) {
  gzFile out = gzopen(file.c_str(), "wb");
  ASSERT_NE(out, nullptr);
  for (const std::string& line : lines) {
    ASSERT_GT(gzputs(out, (line + "\n").c_str()), 0);
  }
  ASSERT_EQ(gzclose(out), Z_OK);
}

nlohmann::json diagnostics(const SmallRobot& robot) {
  return nlohmann::json::parse(read_text(robot.out() / "diagnostics.json"));
}

TEST(GoodInput, EndsWithZeroAndAllOutputs) {
  SmallRobot robot;
  const Outcome outcome = robot.run();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.errors(), SizeIs(0));
  EXPECT_TRUE(robot.has_results(1500));
  EXPECT_TRUE(has_complete_lines(robot.out() / "landmarks.csv", 1 + 4));
}

TEST(BadLog, Missing) {
  SmallRobot robot;
  robot.replace("path: fixes.csv", "path: nowhere.csv");
  EXPECT_TRUE(reports_error(robot.run(), 1,
                            {fmt::format("robot.yaml:{}", robot.yaml_line("nowhere.csv")),
                             robot.file("nowhere.csv").string(), "No such file"}));
  EXPECT_FALSE(std::filesystem::exists(robot.out() / "trajectory.txt"));
}

TEST(BadLog, Folder) {
  SmallRobot robot;
  robot.replace("path: fixes.csv", "path: .");
  EXPECT_TRUE(
      reports_error(robot.run(), 1, {fmt::format("robot.yaml:{}", robot.yaml_line("path: .")), "a file is expected"}));
}

TEST(BadLog, NotReadable) {
  SmallRobot robot;
  robot.write();
  std::filesystem::permissions(robot.file("fixes.csv"), std::filesystem::perms::none);
  std::filesystem::create_directory(robot.out());
  std::filesystem::permissions(robot.out(), std::filesystem::perms(0777));
  const Outcome outcome = robot.command().in_child([] { drop_privileges(); }).run();
  EXPECT_TRUE(reports_error(outcome, 1, {robot.file("fixes.csv").string(), "Permission denied"}));
}

TEST(BadLog, WithoutRows) {
  SmallRobot robot;
  robot.fixes.resize(1);
  EXPECT_TRUE(reports_error(robot.run(), 1, {robot.file("fixes.csv").string(), "no data rows"}));
}

TEST(BadLog, Empty) {
  SmallRobot robot;
  robot.fixes.clear();
  EXPECT_TRUE(reports_error(robot.run(), 1, {robot.file("fixes.csv").string(), "no data rows"}));
}

TEST(BadLog, TruncatedGzipKeepsTheResultsUntilThere) {
  SmallRobot robot;
  robot.replace("path: scans.csv", "path: scans.csv.gz");
  robot.write();
  write_gzip(robot.file("scans.csv.gz"), robot.scans);
  std::filesystem::resize_file(robot.file("scans.csv.gz"), std::filesystem::file_size(robot.file("scans.csv.gz")) / 2);
  EXPECT_TRUE(reports_error(robot.command().run(), 1,
                            {robot.file("scans.csv.gz").string() + ":", "the gzip stream ends early"}));
  EXPECT_TRUE(robot.has_results(100));
}

/// One row of fixes.csv that is bad, and what the user reads about it.
struct BadRow {
  const char* name;
  const char* row;
  std::vector<std::string> expected;
};

void PrintTo(const BadRow& row, std::ostream* out) { *out << row.name; }

class BadFix : public testing::TestWithParam<BadRow> {
 protected:
  static constexpr std::size_t kLine = 21;
  BadFix() { at_line(robot_.fixes, kLine) = GetParam().row; }
  SmallRobot robot_;
};

TEST_P(BadFix, StopsTheRunAndKeepsTheResultsUntilThere) {
  std::vector<std::string> expected = GetParam().expected;
  expected.push_back(robot_.place("fixes.csv", kLine) + ": ");
  expected.emplace_back("max_bad_rows allows 0");
  EXPECT_TRUE(reports_error(robot_.run(), 1, expected));
  EXPECT_TRUE(robot_.has_results(800));
  EXPECT_LT(lines_of(read_text(robot_.out() / "trajectory.txt")).size(), 1300u);
}

TEST_P(BadFix, IsCountedReportedAndSkippedIfAllowed) {
  robot_.replace("max_bad_rows: 0", "max_bad_rows: 1");
  const Outcome outcome = robot_.run();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.errors(), SizeIs(0));
  const std::string place = robot_.place("fixes.csv", kLine);
  EXPECT_THAT(outcome.err, HasSubstr("waymark: skipped " + place + ": "));
  EXPECT_TRUE(robot_.has_results(1500));
  const nlohmann::json run = diagnostics(robot_)["run"];
  EXPECT_EQ(run["bad_record_count"], 1);
  EXPECT_EQ(run["bad_records"][0]["place"], place);
  for (const std::string& part : GetParam().expected)
    EXPECT_THAT(run["bad_records"][0]["reason"].get<std::string>(), HasSubstr(part));
}

INSTANTIATE_TEST_SUITE_P(
    Log, BadFix,
    testing::Values(BadRow{"TooFewColumns", "19.250,9.6", {"too few columns: 2, at least 3 are expected"}},
                    BadRow{"Text", "19.250,far,0.0", {"\"far\"", "east_m", "is not a number"}},
                    BadRow{"Nan", "19.250,nan,0.0", {"\"nan\"", "east_m", "is not finite"}},
                    BadRow{"Infinity", "19.250,9.6,inf", {"\"inf\"", "north_m", "is not finite"}},
                    BadRow{"MinusInfinity", "19.250,9.6,-inf", {"\"-inf\"", "north_m", "is not finite"}},
                    BadRow{"NanTime", "nan,9.6,0.0", {"\"nan\"", "time", "is not finite"}},
                    BadRow{"Empty", "19.250,,0.0", {"east_m", "is empty, a number is expected"}},
                    BadRow{"StampGoesBack", "3.000,9.6,0.0", {"time goes back by 15.25 s, from 18.25"}},
                    BadRow{"JumpBackByYears", "-63072000,9.6,0.0", {"time goes back by 63072018.25 s"}},
                    BadRow{"JumpAheadByYears",
                           "63072000,9.6,0.0",
                           {"time jumps forward by 63071981.75 s", "max_time_jump_s is 3600"}},
                    BadRow{"TimeOutOfRange", "1e30,9.6,0.0", {"\"1e30\"", "time", "out of range"}}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(BadLog, MoreBadRowsThanAllowed) {
  SmallRobot robot;
  robot.replace("max_bad_rows: 0", "max_bad_rows: 2");
  for (const std::size_t line : {5u, 10u, 15u}) at_line(robot.fixes, line) = "x,y,z";
  EXPECT_TRUE(
      reports_error(robot.run(), 1, {robot.place("fixes.csv", 15), "bad row number 3", "max_bad_rows allows 2"}));
  EXPECT_TRUE(robot.has_results(500));
  EXPECT_EQ(diagnostics(robot)["run"]["bad_record_count"], 3);
}

TEST(BadLog, ScanWithAnotherNumberOfBeams) {
  SmallRobot robot;
  at_line(robot.scans, 52) += ",40.000";
  EXPECT_TRUE(reports_error(robot.run(), 1,
                            {robot.place("scans.csv", 52), "123 fields, but the first row of this file has 122"}));
  EXPECT_TRUE(robot.has_results(400));
}

TEST(OddLog, ScansOfNoReturnsOnlyAreLegal) {
  SmallRobot robot;
  for (std::size_t i = 1; i < robot.scans.size(); ++i) {
    std::string& row = robot.scans[i];
    row.resize(row.find(','));
    for (int k = 0; k < kBeams; ++k) row += ",40.000";
  }
  const Outcome outcome = robot.run();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.errors(), SizeIs(0));
  EXPECT_TRUE(robot.has_results(1500));
  EXPECT_TRUE(has_complete_lines(robot.out() / "landmarks.csv", 1));
  EXPECT_EQ(diagnostics(robot)["landmarks"][0]["confirmed"], 0);
}

TEST(BadLog, WithoutAnyFixForTheStart) {
  SmallRobot robot;
  robot.replace("x_m: 0, y_m: 0, position_sigma_m: 0.1, ", "");
  for (std::size_t i = 1; i < robot.fixes.size(); ++i) robot.fixes[i].resize(robot.fixes[i].find(','));
  for (std::size_t i = 1; i < robot.fixes.size(); ++i) robot.fixes[i] += ",x,y";
  robot.replace("max_bad_rows: 0", "max_bad_rows: 100");
  EXPECT_TRUE(reports_error(robot.run(), 1, {"the filter never started", "initial.x_m"}));
}

TEST(Evaluate, EstimateAndReferenceWithoutCommonTimes) {
  const TemporaryFolder folder;
  std::string early;
  std::string late;
  for (int i = 0; i < 20; ++i) {
    early += fmt::format("{} {} 0 0 0 0 0 1\n", i, i);
    late += fmt::format("{} {} 0 0 0 0 0 1\n", 1000 + i, i);
  }
  const std::string estimate = (folder / "early.txt").string();
  const std::string reference = (folder / "late.txt").string();
  write_text(estimate, early);
  write_text(reference, late);
  EXPECT_TRUE(reports_error(waymark({"evaluate", "--estimate", estimate, "--reference", reference}), 1,
                            {estimate, reference, "time"}));
}

/// Positions of a point of the robot do not show the covariance of its base.
TEST(Evaluate, CovarianceOfTheBaseAgainstPositionsOfAnotherPoint) {
  const TemporaryFolder folder;
  std::string poses;
  std::string positions = "t_s,x_m,y_m\n";
  std::string covariances = "t_s,xx,xy,xyaw,yy,yyaw,yawyaw\n";
  for (int i = 0; i < 20; ++i) {
    poses += fmt::format("{} {} 0 0 0 0 0.6 0.8\n", i, i);
    positions += fmt::format("{},{},0.1\n", i, i);
    covariances += fmt::format("{},0.01,0,0,0.01,0,0.01\n", i);
  }
  const auto file = [&](const char* name, const std::string& text) {
    write_text(folder / name, text);
    return (folder / name).string();
  };
  const std::vector<std::string> score{"evaluate",
                                       "--estimate",
                                       file("poses.txt", poses),
                                       "--reference",
                                       file("positions.csv", positions),
                                       "--covariance",
                                       file("covariance.csv", covariances)};
  const Outcome outcome = waymark(score);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, testing::HasSubstr("NEES of x, y  "));
  EXPECT_THAT(outcome.out, testing::HasSubstr("mean 1.00"));
  EXPECT_THAT(outcome.out, testing::HasSubstr("right: mean 2"));
  std::vector<std::string> antenna = score;
  antenna.insert(antenna.end(), {"--lever-arm", "1,0,0"});
  EXPECT_THAT(waymark(antenna).out, testing::HasSubstr("NEES of x, y  "));
  // Where the reference turns, the base is known: here the point 1 m ahead of it is where the reference is.
  std::string ahead;
  for (int i = 0; i < 20; ++i) ahead += fmt::format("{} {} 0.96 0 0 0 0.6 0.8\n", i, i + 0.28);
  antenna[4] = file("ahead.txt", ahead);
  const Outcome of_base = waymark(antenna);
  EXPECT_EQ(of_base.exit_code, 0) << of_base.err;
  EXPECT_THAT(of_base.out, testing::ContainsRegex("NEES of x, y, yaw +mean 0.00"));
}

TEST(Evaluate, MissingFile) {
  const TemporaryFolder folder;
  const std::string missing = (folder / "missing.txt").string();
  EXPECT_TRUE(
      reports_error(waymark({"evaluate", "--estimate", missing, "--reference", missing}), 1, {missing, "not found"}));
}

}  // namespace
}  // namespace waymark::system_test
