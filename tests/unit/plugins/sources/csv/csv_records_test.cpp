// SPDX-License-Identifier: Apache-2.0
// Rows of several types in one file, scans with one beam a row, and attitudes as quaternions.
#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "unit/plugins/sources/csv/csv_fixture.hpp"

namespace waymark {
namespace {

using csv_test::CsvTest;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

constexpr float kNoReturn = std::numeric_limits<float>::infinity();

class CsvRecords : public CsvTest {};

const std::string kMixed =
    "ODO,0.0,1,2\nSCAN,0.05,1,2,3\n\"GPS\",0.1,51,13,4,9\nODO,0.1,3,4\nSCAN,0.15,4,5,6\nNOTE\nODO,0.2,5,6\n";

TEST_F(CsvRecords, AFileMayHoldSeveralTypesOfRecords) {
  write("a.log", kMixed);
  const auto source = make(
      "files:\n"
      "  - { path: a.log, sensor: wheels, payload: WheelSpeeds, where: [{ column: 0, equals: ODO }], time: 1,"
      " columns: { left_mps: 2, right_mps: 3 } }\n"
      "  - { path: a.log, sensor: gps, payload: GnssFix, where: [{ column: 0, in: [GPS, GNSS] }], time: 1,"
      " columns: { latitude_deg: 2, longitude_deg: 3, satellites: 5 } }\n"
      "  - { path: a.log, sensor: lidar, payload: LaserScan, where: [{ column: 0, equals: SCAN }], time: 1,"
      " columns: { ranges_m: { first: 2, count: 3 } }, scan: { start_deg: 0, step_deg: 1 } }\n");
  std::string order;
  for (const Measurement& one : read_all(*source)) order += source->channels().at(one.sensor).sensor[0];
  EXPECT_EQ(order, "wlwglw");
}

TEST_F(CsvRecords, AConditionOnTextExcludesToo) {
  write("a.csv", "0,1,2,ok\n1,3,4,bad\n2,5,6,ok\n");
  const auto kept = [this](const std::string& condition) {
    return read_all(*make(csv_test::wheels_yaml("a.csv", ", where: [{ column: 3, " + condition + " }]"))).size();
  };
  EXPECT_EQ(kept("not_in: [bad, worse]"), 2u);
  EXPECT_EQ(kept("not_in: [ok]"), 1u);
  EXPECT_EQ(kept("in: [ok, 7]"), 2u);  // with a text among them all are texts
}

TEST_F(CsvRecords, LaterConditionsAreAskedOfTheRowsThatTheFirstOnesKeep) {
  write("a.csv", "A,0,1,2,9\nB,0.5\nA,1,3,4,5\nC,1.5,x,y,z\nA,2,5,6\n");
  const auto source = make(
      "max_bad_rows: 1\nfiles: [{ path: a.csv, sensor: wheels, payload: WheelSpeeds, time: 1,"
      " where: [{ column: 0, equals: A }, { column: 4, min: 6 }], columns: { left_mps: 2, right_mps: 3 } }]");
  EXPECT_THAT(read_all(*source), SizeIs(1));
  ASSERT_THAT(source->bad_records(), SizeIs(1));
  EXPECT_THAT(source->bad_records()[0].reason, HasSubstr("too few columns: 4, at least 5 are expected by `where`"));
}

class CsvLongScans : public CsvTest {
 protected:
  static std::string entry(const std::string& more = ", group_by_time: true",
                           const std::string& columns = "bearing_deg: 1, range_m: 2") {
    return "max_bad_rows: 1\nfiles: [{ path: a.csv, sensor: lidar, payload: LaserScan, time: 0" + more +
           ", columns: { " + columns + " }, scan: { start_deg: -2, step_deg: 1, beam_interval_s: 0.1 } }]";
  }
};

TEST_F(CsvLongScans, RowsOfEqualTimeAreOneScan) {
  write("a.csv", "0,-2,1\n0,-1,2\n0,1,4\n1,-2,5\n1,0,6\n");
  const auto scans = read_all(*make(entry()));
  ASSERT_THAT(scans, SizeIs(2));
  EXPECT_THAT(scans[0].as<LaserScan>().ranges_m, ElementsAre(1.0f, 2.0f, kNoReturn, 4.0f));
  EXPECT_THAT(scans[1].as<LaserScan>().ranges_m, ElementsAre(5.0f, kNoReturn, 6.0f));
  EXPECT_NEAR(scans[0].as<LaserScan>().start_rad, -2.0 * std::numbers::pi / 180.0, 1e-15);
}

TEST_F(CsvLongScans, BeamsGoToTheNearestDirectionAndOfTwoTheNearerCounts) {
  write("a.csv", "0,-2.4,3\n0,-0.6,2\n0,-1.3,1\n0,359.7,7\n");
  const auto scans = read_all(*make(entry()));
  EXPECT_THAT(scans.at(0).as<LaserScan>().ranges_m, ElementsAre(3.0f, 1.0f, 7.0f));
}

TEST_F(CsvLongScans, BeamsHaveUnitsAndIntensities) {
  write("a.csv", "0,-2000,1500,9\n0,0,2500,8\n");
  const auto scans = read_all(
      *make(entry(", group_by_time: true", "bearing_deg: { column: 1, scale: 1e-3 }, range_mm: 2, intensity: 3")));
  EXPECT_THAT(scans.at(0).as<LaserScan>().ranges_m, ElementsAre(1.5f, kNoReturn, 2.5f));
  EXPECT_THAT(scans.at(0).as<LaserScan>().intensities, ElementsAre(9.0f, 0.0f, 8.0f));
}

TEST_F(CsvLongScans, ABadBeamCostsItselfOnly) {
  write("a.csv", "0,-2,1\n0,-1,x\n0,0,3\n");
  const auto source = make(entry());
  const auto scans = read_all(*source);
  EXPECT_THAT(scans.at(0).as<LaserScan>().ranges_m, ElementsAre(1.0f, kNoReturn, 3.0f));
  EXPECT_THAT(source->bad_records().at(0).reason,
              HasSubstr("\"x\" in column 2 counted from 0 (range_m) is not a number"));
}

TEST_F(CsvLongScans, BearingsInAnotherUnitAreNamed) {
  write("a.csv", "0,-90,1\n0,90,2\n");
  EXPECT_THAT(
      reading_error(*make(entry(", group_by_time: true", "bearing_rad: 1, range_m: 2"))),
      AllOf(HasSubstr("a.csv:2: \"90\" in column 1 counted from 0 (bearing_rad) lies a turn or more from scan.start"),
            HasSubstr("is its unit right?")));
}

TEST_F(CsvLongScans, OneBeamIsNoScan) {
  write("a.csv", "0,-2,1\n");
  EXPECT_THAT(construction_error<ConfigError>(entry("")),
              HasSubstr("group_by_time: a row is one beam of a scan here: true is expected"));
  EXPECT_THAT(construction_error<ConfigError>(entry(", group_by_time: true", "range_m: 2")),
              HasSubstr("a beam of LaserScan needs the column \"bearing_rad\""));
}

TEST_F(CsvLongScans, AScanOfBeamsMayEndAtItsStamp) {
  write("a.csv", "1,-2,1\n1,1,4\n2,-2,5\n");
  const auto scans = read_all(*make(entry(", group_by_time: true, end_of_interval: true")));
  ASSERT_THAT(scans, SizeIs(2));
  EXPECT_DOUBLE_EQ(to_seconds(scans[0].stamp.time_since_epoch()), 0.7);
  EXPECT_EQ(to_seconds(scans[0].arrival.time_since_epoch()), 1.0);
  EXPECT_EQ(to_seconds(scans[1].stamp.time_since_epoch()), 2.0);
}

class CsvQuaternions : public CsvTest {};

TEST_F(CsvQuaternions, PosesOfOdometryMayHaveQuaternions) {
  write("a.csv", "0,1,2,0,0,0,1\n1,1,5,0,0,0.7071068,0.7071068\n");
  const auto motions =
      read_all(*make("files: [{ path: a.csv, sensor: wheels, payload: PoseIncrement, time: 0, cumulative: true,"
                     " columns: { x_m: 1, y_m: 2, q_x: 3, q_y: 4, q_z: 5, q_w: 6 } }]"));
  ASSERT_THAT(motions, SizeIs(1));
  EXPECT_NEAR(motions[0].as<PoseIncrement>().y_m, 3.0, 1e-12);
  EXPECT_NEAR(motions[0].as<PoseIncrement>().yaw_rad, 0.5 * std::numbers::pi, 1e-6);
}

TEST_F(CsvQuaternions, AReferenceInTheFormatOfTumIsRead) {
  write("a.csv", "0,1,2\n");
  write("truth.txt", "# timestamp tx ty tz qx qy qz qw\n0 1 2 0 0 0 0.7071068 0.7071068\n1 2 3 0 0 0 0 0\n");
  const auto source = make(csv_test::wheels_yaml("a.csv") +
                           "reference: { trajectory: { path: truth.txt, columns:"
                           " { time: 0, x_m: 1, y_m: 2, q_x: 4, q_y: 5, q_z: 6, q_w: 7 } } }\n");
  const auto& points = source->reference()->trajectory;
  ASSERT_THAT(points, SizeIs(2));
  EXPECT_NEAR(points[0].T_map_base.yaw(), 0.5 * std::numbers::pi, 1e-6);
  EXPECT_TRUE(points[0].has_yaw);
  EXPECT_FALSE(points[1].has_yaw);  // four zeros: unknown
}

TEST_F(CsvQuaternions, HalfAnAttitudeIsRefused) {
  write("a.csv", "0,1,2,0,0,0,1\n");
  const auto error = [this](const std::string& columns) {
    return construction_error<ConfigError>(
        "files: [{ path: a.csv, sensor: wheels, payload: PoseIncrement, time: 0, cumulative: true, columns: { x_m: 1, "
        "y_m: 2" +
        columns + " } }]");
  };
  EXPECT_THAT(error(", q_w: 3, q_x: 4"), HasSubstr("\"q_w\", \"q_x\", \"q_y\" and \"q_z\", or none of them"));
  EXPECT_THAT(error(", q_w: 3, q_x: 4, q_y: 5, q_z: 6, yaw_rad: 3"), HasSubstr("either the yaw or the quaternion"));
  EXPECT_THAT(error(""), HasSubstr("needs the column \"yaw_rad\""));
}

}  // namespace
}  // namespace waymark
