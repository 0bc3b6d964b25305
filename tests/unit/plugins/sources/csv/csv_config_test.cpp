// SPDX-License-Identifier: Apache-2.0
// Keys of the source csv that do not fit the file, the payload or the robot.
#include <gmock/gmock.h>

#include <string>

#include "unit/plugins/sources/csv/csv_fixture.hpp"

namespace waymark {
namespace {

using csv_test::CsvTest;
using csv_test::wheels_yaml;
using ::testing::AllOf;
using ::testing::HasSubstr;

class CsvConfig : public CsvTest {};

TEST_F(CsvConfig, UnknownHeaderName) {
  write("a.csv", "time,left,right\n0,1,2\n");
  EXPECT_THAT(construction_error<ConfigError>("files:\n  - path: a.csv\n    sensor: wheels\n    payload: WheelSpeeds\n"
                                              "    time: 0\n    columns: {left_mps: lefft, right_mps: right}\n"),
              AllOf(HasSubstr("run.yaml:6:"), HasSubstr("\"lefft\""), HasSubstr("did you mean \"left\""),
                    HasSubstr("time, left, right")));
}

TEST_F(CsvConfig, HeaderNameWithoutHeader) {
  write("a.csv", "0,1,2\n");
  EXPECT_THAT(construction_error<ConfigError>("files: [{path: a.csv, sensor: wheels, payload: WheelSpeeds, time: t, "
                                              "columns: {left_mps: 1, right_mps: 2}}]"),
              HasSubstr("the file has no header row"));
}

TEST_F(CsvConfig, TwoSensorsOnOneInput) {
  write("a.csv", "0,1,2\n");
  const std::string second = "  - {path: ./a.csv, sensor: other, payload: WheelSpeeds, time: 0, columns: ";
  EXPECT_THAT(construction_error<ConfigError>(wheels_yaml("a.csv") + second + "{right_mps: 2, left_mps: 1}}\n"),
              AllOf(HasSubstr("two sensors on one input"), HasSubstr("\"wheels\""), HasSubstr("\"other\"")));
  EXPECT_NO_THROW(make(wheels_yaml("a.csv") + second + "{right_mps: 1, left_mps: 2}}\n"));
}

TEST_F(CsvConfig, UnknownPayload) {
  write("a.csv", "0,1,2\n");
  EXPECT_THAT(construction_error<ConfigError>(
                  "files: [{path: a.csv, sensor: lidar, payload: LaserScn, time: 0, columns: {left_mps: 1}}]"),
              HasSubstr("there is no payload \"LaserScn\"; did you mean \"LaserScan\"?"));
}

TEST_F(CsvConfig, FieldThatThePayloadLacks) {
  write("a.csv", "0,1,2\n");
  EXPECT_THAT(construction_error<ConfigError>("files: [{path: a.csv, sensor: wheels, payload: WheelSpeeds, time: 0, "
                                              "columns: {left_mps: 1, rigt_mps: 2}}]"),
              HasSubstr("WheelSpeeds has no field \"rigt_mps\"; did you mean \"right_mps\"?"));
}

TEST_F(CsvConfig, RequiredFieldThatIsNotMapped) {
  write("a.csv", "0,1,2\n");
  EXPECT_THAT(
      construction_error<ConfigError>(
          "files: [{path: a.csv, sensor: wheels, payload: WheelSteering, time: 0, columns: {steering_rad: 1}}]"),
      HasSubstr("WheelSteering needs the column \"speed_mps\""));
}

TEST_F(CsvConfig, FixWithoutPosition) {
  write("a.csv", "0,1,2\n");
  EXPECT_THAT(construction_error<ConfigError>(
                  "files: [{path: a.csv, sensor: gps, payload: GnssFix, time: 0, columns: {east_m: 1, hdop: 2}}]"),
              HasSubstr("\"east_m\" and \"north_m\", or \"latitude_deg\" and \"longitude_deg\""));
}

TEST_F(CsvConfig, AsManyIntensitiesAsRanges) {
  write("a.csv", "0,1,2,3\n");
  EXPECT_THAT(construction_error<ConfigError>(
                  "files: [{path: a.csv, sensor: lidar, payload: LaserScan, time: 0, columns: {ranges_m: {first: 1, "
                  "count: 2}, intensities: {first: 3, count: 1}}, scan: {start_deg: 0, step_deg: 1}}]"),
              HasSubstr("1 columns for 2 ranges"));
}

TEST_F(CsvConfig, UnknownSensor) {
  write("a.csv", "0,1,2\n");
  EXPECT_THAT(construction_error<ConfigError>("files: [{path: a.csv, sensor: wheel, payload: WheelSpeeds, time: 0, "
                                              "columns: {left_mps: 1, right_mps: 2}}]"),
              AllOf(HasSubstr("no sensor \"wheel\""), HasSubstr("did you mean \"wheels\"?")));
}

TEST_F(CsvConfig, SensorThatTakesAnotherPayload) {
  write("a.csv", "0,1,2\n");
  EXPECT_THAT(construction_error<ConfigError>("files: [{path: a.csv, sensor: lidar, payload: WheelSpeeds, time: 0, "
                                              "columns: {left_mps: 1, right_mps: 2}}]"),
              AllOf(HasSubstr("waymark/LaserScan@1"), HasSubstr("waymark/WheelSpeeds@1")));
}

TEST_F(CsvConfig, GroupingWhatFormsNoSet) {
  write("a.csv", "0,1,2\n");
  EXPECT_THAT(construction_error<ConfigError>(wheels_yaml("a.csv", ", group_by_time: true")),
              HasSubstr("group_by_time"));
}

TEST_F(CsvConfig, UnknownKeyOfAFile) {
  write("a.csv", "0,1,2\n");
  EXPECT_THAT(construction_error<ConfigError>(wheels_yaml("a.csv", ", delimeter: ','")), HasSubstr("delimeter"));
}

TEST_F(CsvConfig, UnknownDelimiter) {
  write("a.csv", "0,1,2\n");
  EXPECT_THAT(construction_error<ConfigError>(wheels_yaml("a.csv", ", delimiter: comma")), HasSubstr("\"comma\""));
}

TEST_F(CsvConfig, ConditionThatSaysNothing) {
  write("a.csv", "0,1,2\n");
  EXPECT_THAT(construction_error<ConfigError>(wheels_yaml("a.csv", ", where: [{column: 1}]")),
              HasSubstr("equals, in, not_in, min or max"));
}

TEST_F(CsvConfig, NoFiles) { EXPECT_THAT(construction_error<ConfigError>("files: []\n"), HasSubstr("files")); }

}  // namespace
}  // namespace waymark
