// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <sstream>

#include "unit/plugins/sources/csv/csv_fixture.hpp"

namespace waymark {
namespace {

using csv_test::CsvTest;
using csv_test::gzip;
using csv_test::wheels_yaml;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

class CsvErrors : public CsvTest {
 protected:
  std::string at(const std::string& file, int line) const {
    return (folder_ / file).string() + ":" + std::to_string(line) + ": ";
  }
  /// What reading `a.csv` as wheel speeds ends with.
  std::string wheels_error(const std::string& content, const std::string& more = "") {
    write("a.csv", content);
    return reading_error(*make(wheels_yaml("a.csv", more)));
  }
};

// --- the file
// ---------------------------------------------------------------------------------------------------------

TEST_F(CsvErrors, MissingFile) {
  EXPECT_THAT(construction_error<ConfigError>(wheels_yaml("none.csv")),
              AllOf(HasSubstr("run.yaml:2:"), HasSubstr("none.csv"), HasSubstr("No such file")));
}

TEST_F(CsvErrors, Folder) {
  std::filesystem::create_directory(folder_ / "logs");
  EXPECT_THAT(construction_error<ConfigError>(wheels_yaml("logs")), HasSubstr("logs is a folder, a file is expected"));
}

TEST_F(CsvErrors, UnreadableFile) {
  write("a.csv", "0,1,2\n");
  std::filesystem::permissions(folder_ / "a.csv", std::filesystem::perms::none);
  if (::access((folder_ / "a.csv").c_str(), R_OK) == 0) GTEST_SKIP() << "this user may read everything";
  EXPECT_THAT(construction_error<ConfigError>(wheels_yaml("a.csv")), HasSubstr("Permission denied"));
}

class CsvWithoutRows : public CsvErrors, public ::testing::WithParamInterface<std::string> {};
TEST_P(CsvWithoutRows, IsAnError) {
  write("a.csv", GetParam());
  EXPECT_EQ(construction_error<DataError>(wheels_yaml("a.csv")), (folder_ / "a.csv").string() + ": no data rows");
}
INSTANTIATE_TEST_SUITE_P(Files, CsvWithoutRows,
                         ::testing::Values("", "\n\n", "# comment\n", "t,left,right\n", gzip("t,left,right\n")));

TEST_F(CsvErrors, LineWithoutEnd) {
  const std::string endless(std::size_t{70} << 20, '1');
  write("first.csv", endless);
  EXPECT_EQ(construction_error<DataError>(wheels_yaml("first.csv")),
            at("first.csv", 1) + "the line is longer than 64 MiB");
  write("second.csv", "t,left,right\n" + endless);
  EXPECT_EQ(construction_error<DataError>(wheels_yaml("second.csv")),
            at("second.csv", 2) + "the line is longer than 64 MiB");
}

TEST_F(CsvErrors, TruncatedGzipAfterTheHeader) {
  const std::string packed = gzip("t,left,right\n0,1,2\n", 13);
  write("a.csv.gz", packed.substr(0, 10 + 5 + 13 + 5 + 2));
  EXPECT_THAT(construction_error<DataError>(wheels_yaml("a.csv.gz")), HasSubstr("the gzip stream ends early"));
}

TEST_F(CsvErrors, TruncatedGzipAfterAllCompleteRows) {
  const std::string packed = gzip("0,1,2\n1,1,2\n2,1,2\n3,1,2\n", 5);
  const auto in_the_third_row = 10 + 3 * (5 + 5) + 3;
  write("a.csv.gz", packed.substr(0, in_the_third_row));
  std::vector<Measurement> good;
  const std::string error = reading_error(*make(wheels_yaml("a.csv.gz")), &good);
  EXPECT_EQ(error, at("a.csv.gz", 3) + "the gzip stream ends early");
  EXPECT_EQ(good.size(), 2u);
}

TEST_F(CsvErrors, GzipWithoutItsChecksumIsTruncated) {
  const std::string packed = gzip("0,1,2\n1,1,2\n");
  write("a.csv.gz", packed.substr(0, packed.size() - 3));
  std::vector<Measurement> good;
  EXPECT_THAT(reading_error(*make(wheels_yaml("a.csv.gz")), &good), HasSubstr("the gzip stream ends early"));
  EXPECT_EQ(good.size(), 2u);
}

TEST_F(CsvErrors, TruncatedInTheFirstRow) {
  write("a.csv.gz", gzip("0,1,2\n1,1,2\n").substr(0, 16));
  EXPECT_EQ(construction_error<DataError>(wheels_yaml("a.csv.gz")), at("a.csv.gz", 1) + "the gzip stream ends early");
}

TEST_F(CsvErrors, DamagedGzip) {
  std::string packed = gzip("0,1,2\n1,1,2\n2,1,2\n");
  packed[packed.size() - 6] ^= 0x55;  // in the checksum
  write("a.csv.gz", packed);
  std::vector<Measurement> good;
  EXPECT_THAT(reading_error(*make(wheels_yaml("a.csv.gz")), &good), HasSubstr("the gzip stream is damaged"));
  EXPECT_EQ(good.size(), 3u);
}

TEST_F(CsvErrors, BytesAfterTheGzipStream) {
  write("a.csv.gz", gzip("0,1,2\n1,1,2\n") + "2,1,2\n");
  EXPECT_THAT(reading_error(*make(wheels_yaml("a.csv.gz"))), HasSubstr("other bytes after the end of the gzip stream"));
}

TEST_F(CsvErrors, WhatOtherFilesHaveUntilThenIsDelivered) {
  write("a.csv.gz", gzip("0,1,2\n5,1,2\n9,1,2\n").substr(0, 10 + 5 + 14));
  write("b.csv", "1,1,2\n4,1,2\n6,1,2\n");
  const auto source = make(
      "files:\n"
      "  - {path: a.csv.gz, sensor: wheels, payload: WheelSpeeds, time: 0, columns: {left_mps: 1, right_mps: 2}}\n"
      "  - {path: b.csv, sensor: other, payload: WheelSpeeds, time: 0, columns: {left_mps: 1, right_mps: 2}}\n");
  std::vector<Measurement> good;
  EXPECT_THAT(reading_error(*source, &good), HasSubstr("ends early"));
  EXPECT_EQ(good.size(), 4u);
  EXPECT_THROW(source->next(), DataError);
}

// --- rows
// -------------------------------------------------------------------------------------------------------------

TEST_F(CsvErrors, TooFewColumns) {
  EXPECT_THAT(wheels_error("0,1,2\n1,1\n"), StartsWith(at("a.csv", 2) + "too few columns: 2, at least 3 are expected"));
}

TEST_F(CsvErrors, TextForANumber) {
  EXPECT_THAT(wheels_error("t,l,r\n0,1,2\n1,fast,2\n"),
              StartsWith(at("a.csv", 3) + "\"fast\" in column \"l\" (left_mps) is not a number"));
}

TEST_F(CsvErrors, ColumnsHaveTheNamesOfTheHeaderIfThoseAreUnique) {
  EXPECT_THAT(wheels_error("t,v,v\n0,1,2\n1,fast,2\n"), HasSubstr("in column 1 counted from 0 (left_mps)"));
  EXPECT_THAT(wheels_error("t,,v\n0,1,2\n1,fast,2\n"), HasSubstr("in column 1 counted from 0 (left_mps)"));
}

TEST_F(CsvErrors, NumberWithATail) {
  EXPECT_THAT(wheels_error("0,1,2\n1,1.5m,2\n"),
              HasSubstr("\"1.5m\" in column 1 counted from 0 (left_mps) is not a number"));
}

TEST_F(CsvErrors, EmptyField) {
  EXPECT_THAT(wheels_error("0,1,2\n1,,2\n"),
              StartsWith(at("a.csv", 2) + "column 1 counted from 0 (left_mps) is empty"));
}

class CsvNonFinite : public CsvErrors, public ::testing::WithParamInterface<std::string> {};
TEST_P(CsvNonFinite, IsABadRow) {
  EXPECT_THAT(
      wheels_error("0,1,2\n1,2," + GetParam() + "\n"),
      StartsWith(at("a.csv", 2) + "\"" + GetParam() + "\" in column 2 counted from 0 (right_mps) is not finite"));
}
TEST_P(CsvNonFinite, IsABadTime) {
  EXPECT_THAT(wheels_error("0,1,2\n" + GetParam() + ",1,2\n"),
              StartsWith(at("a.csv", 2) + "\"" + GetParam() + "\" in column 0 counted from 0 (time) is not finite"));
}
INSTANTIATE_TEST_SUITE_P(Words, CsvNonFinite, ::testing::Values("nan", "NaN", "inf", "-inf", "+Infinity"));

TEST_F(CsvErrors, NumberBeyondADouble) {
  EXPECT_THAT(wheels_error("0,1,2\n1,1e999,2\n"),
              HasSubstr("\"1e999\" in column 1 counted from 0 (left_mps) is out of range"));
}

TEST_F(CsvErrors, TimeBeyondInt64) {
  EXPECT_THAT(wheels_error("99999999999,1,2\n"),
              HasSubstr("\"99999999999\" in column 0 counted from 0 (time) is out of range"));
}

TEST_F(CsvErrors, TimeWithoutADifference) {
  for (const std::string time : {"4611686019", "-4611686019", "9200000000", "-9200000000"}) {
    EXPECT_THAT(wheels_error("0,1,2\n" + time + ",1,2\n"),
                HasSubstr('"' + time + "\" in column 0 counted from 0 (time) is out of range"));
  }
  write("a.csv", "-4611686018,1,2\n4611686018,1,2\n");
  EXPECT_EQ(read_all(*make(wheels_yaml("a.csv", "", "max_time_jump_s: 1.0e+12\nmax_bad_rows: 1\n"))).size(), 1u)
      << "292 years are a jump, whatever is allowed";
}

TEST_F(CsvErrors, TimeGoesBack) {
  EXPECT_THAT(wheels_error("5,1,2\n6,1,2\n5.75,1,2\n"), StartsWith(at("a.csv", 3) + "time goes back by 0.25 s"));
}

TEST_F(CsvErrors, TimeJumpsByYears) {
  EXPECT_THAT(wheels_error("5,1,2\n63072005,1,2\n"),
              StartsWith(at("a.csv", 2) + "time jumps forward by 63072000 s; max_time_jump_s is 3600"));
}

TEST_F(CsvErrors, RowsAfterAJumpAreComparedWithTheLastGoodOne) {
  write("a.csv", "5,1,2\n63072005,1,2\n6,1,2\n");
  const auto source = make(wheels_yaml("a.csv", "", "max_bad_rows: 1\n"));
  EXPECT_EQ(read_all(*source).size(), 2u);
}

TEST_F(CsvErrors, EqualStampsAreFine) {
  write("a.csv", "5,1,2\n5,1,2\n");
  EXPECT_EQ(read_all(*make(wheels_yaml("a.csv"))).size(), 2u);
}

TEST_F(CsvErrors, StampAfterItsArrival) {
  EXPECT_THAT(wheels_error("5,1,2,4.5\n", ", arrival: 3"), HasSubstr("the stamp lies 0.5 s after the arrival"));
  write("a.csv", "5,1,2,4.5\n");
  EXPECT_EQ(read_all(*make("max_ahead_s: 0.5\n" + wheels_yaml("a.csv", ", arrival: 3"))).size(), 1u);
}

TEST_F(CsvErrors, AnEmptyRequiredFieldUnlessInvalidRowsAreKept) {
  EXPECT_THAT(wheels_error("5,,2\n", ""), HasSubstr("is empty"));
  write("a.csv", "5,,2\n");
  for (const std::string key : {"keep_invalid", "required_may_be_empty"}) {  // the second is its old name
    const auto all = read_all(*make(wheels_yaml("a.csv", ", " + key + ": true")));
    ASSERT_EQ(all.size(), 1u);
    EXPECT_TRUE(std::isnan(all[0].as<WheelSpeeds>().left_mps));
    EXPECT_EQ(all[0].as<WheelSpeeds>().right_mps, 2.0);
  }
}

TEST_F(CsvErrors, ARuleOfThePayloadUnlessInvalidRowsAreKept) {
  write("a.csv", "1,-3,0.3,9\n");
  const std::string files =
      "files: [{path: a.csv, sensor: camera, payload: LandmarkObservations, time: 0, columns: {range_m: 1, "
      "bearing_rad: 2, identity: 3}";
  EXPECT_THAT(reading_error(*make(files + "}]")), HasSubstr("a landmark's range is negative"));
  const auto all = read_all(*make(files + ", keep_invalid: true}]"));
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].as<LandmarkObservations>().landmarks.at(0).range_m, -3.0);
}

const std::string kScan =
    "files: [{path: a.csv, sensor: lidar, payload: LaserScan, time: 0, columns: {ranges_m: {first: 1, count: 3}}, "
    "scan: "
    "{start_deg: 0, step_deg: 1}}]";

class CsvBeams : public CsvErrors, public ::testing::WithParamInterface<std::pair<std::string, int>> {};
TEST_P(CsvBeams, AnotherNumberThanBefore) {
  write("a.csv", "0,1,2,3\n1," + GetParam().first + "\n");
  EXPECT_THAT(reading_error(*make(kScan)), StartsWith(at("a.csv", 2) + std::to_string(GetParam().second) +
                                                      " fields, but the first row of this file has 4"));
}
INSTANTIATE_TEST_SUITE_P(Rows, CsvBeams,
                         ::testing::Values(std::pair<std::string, int>{"1,2", 3},
                                           std::pair<std::string, int>{"1,2,3,4", 5}));

TEST_F(CsvErrors, NonFiniteBeam) {
  write("a.csv", "0,1,inf,3\n");
  EXPECT_THAT(reading_error(*make(kScan)),
              StartsWith(at("a.csv", 1) + "\"inf\" in column 2 counted from 0 (ranges_m, beam 1) is not finite"));
  write("a.csv", "t,r0,r1,x\n0,1,inf,3\n");
  EXPECT_THAT(reading_error(*make(kScan)), HasSubstr("\"inf\" in column \"r1\" (ranges_m, beam 1) is not finite"));
}

TEST_F(CsvErrors, IdentityThatIsNoWholeNumber) {
  write("a.csv", "0,1,2,6.5\n");
  EXPECT_THAT(
      reading_error(*make("files: [{path: a.csv, sensor: camera, payload: LandmarkObservations, time: 0, columns: "
                          "{range_m: 1, bearing_rad: 2, identity: 3}}]")),
      HasSubstr("\"6.5\" in column 3 counted from 0 (identity) is not a whole number"));
}

TEST_F(CsvErrors, LatitudeBeyondThePole) {
  write("a.csv", "0,90.5,8\n");
  EXPECT_THAT(reading_error(*make("files: [{path: a.csv, sensor: gps, payload: GnssFix, time: 0, columns: "
                                  "{latitude_deg: 1, longitude_deg: 2}}]")),
              HasSubstr("\"90.5\" in column 1 counted from 0 (latitude_deg) is not a latitude"));
}

TEST_F(CsvErrors, ConditionOnText) {
  EXPECT_THAT(wheels_error("0,1,2,x\n", ", where: [{column: 3, equals: 1}]"),
              HasSubstr("\"x\" in column 3 counted from 0 (where) is not a number"));
}

// --- the limit
// ----------------------------------------------------------------------------------------------------------

TEST_F(CsvErrors, BadRowsAreSkippedUpToTheLimit) {
  write("a.csv", "0,1,2\n1,x,2\n2,1,2\n3,,2\n4,1,2\n");
  const auto source = make(wheels_yaml("a.csv", "", "max_bad_rows: 2\n"));
  EXPECT_EQ(read_all(*source).size(), 3u);
  ASSERT_EQ(source->bad_records().size(), 2u);
  EXPECT_EQ(source->bad_records()[1].place + ": ", at("a.csv", 4));
  EXPECT_THAT(source->bad_records()[0].reason, StartsWith("\"x\" in column 1"));
}

TEST_F(CsvErrors, OneMoreThanTheLimitStopsAndSaysHowToGoOn) {
  write("a.csv", "0,1,2\n1,x,2\n2,1,2\n3,,2\n4,1,2\n");
  std::vector<Measurement> good;
  const std::string error = reading_error(*make(wheels_yaml("a.csv", "", "max_bad_rows: 1\n")), &good);
  EXPECT_THAT(error, AllOf(StartsWith(at("a.csv", 4)), HasSubstr("max_bad_rows allows 1"), Not(HasSubstr("\n"))));
  EXPECT_EQ(good.size(), 2u);
}

TEST_F(CsvErrors, TheListOfBadRowsIsBounded) {
  std::string text = "0,1,2\n";
  for (int i = 0; i < 1500; ++i) text += "bad\n";
  write("a.csv", text);
  const auto source = make(wheels_yaml("a.csv", "", "max_bad_rows: 1499\n"));
  EXPECT_THAT(reading_error(*source), StartsWith(at("a.csv", 1501)));
  EXPECT_EQ(source->bad_records().size(), 1000u);
}

TEST_F(CsvErrors, ReferenceWithABadRowTakesNoMeasurementWithIt) {
  write("a.csv", "0,1,2\n");
  write("truth.csv", "0,1,2\n1,x,2\n");
  const auto source =
      make(wheels_yaml("a.csv") + "reference: {trajectory: {path: truth.csv, columns: {time: 0, x_m: 1, y_m: 2}}}\n");
  try {
    source->reference();
    ADD_FAILURE() << "nothing was thrown";
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(),
                StartsWith(at("truth.csv", 2) + "\"x\" in column 1 counted from 0 (x_m) is not a number"));
  }
  EXPECT_TRUE(source->next().has_value());
}

}  // namespace
}  // namespace waymark
