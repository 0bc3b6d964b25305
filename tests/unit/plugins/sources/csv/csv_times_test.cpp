// SPDX-License-Identifier: Apache-2.0
// Stamps: units, dates, and those of the end of an interval.
#include <gmock/gmock.h>

#include "unit/plugins/sources/csv/csv_fixture.hpp"

namespace waymark {
namespace {

using csv_test::CsvTest;
using csv_test::wheels_yaml;
using ::testing::AllOf;
using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr std::int64_t kNewYear = 1'704'067'200'000'000'000;  // 2024-01-01T00:00:00Z

class CsvTimes : public CsvTest {
 protected:
  static std::string entry(const std::string& time) {
    return "files: [{ path: a.csv, sensor: wheels, payload: WheelSpeeds, " + time +
           ", columns: { left_mps: 1, right_mps: 2 } }]";
  }
  /// Nanoseconds of the stamp in the first column of a row of wheels.
  std::int64_t stamp_of(const std::string& text, const std::string& time = "time: 0") const {
    write("a.csv", text + ",1,1\n");
    return make(entry(time))->next()->stamp.time_since_epoch().count();
  }
  std::string error_of(const std::string& text, const std::string& time = "time: 0") const {
    write("a.csv", text + ",1,1\n");
    return reading_error(*make(entry(time)));
  }
};

TEST_F(CsvTimes, UnixTimeMayBeInAnyUnit) {
  EXPECT_EQ(stamp_of("1704067200.123456789"), kNewYear + 123'456'789);
  EXPECT_EQ(stamp_of("1704067200123.5", "time_ms: 0"), kNewYear + 123'500'000);
  EXPECT_EQ(stamp_of("1704067200123456", "time_us: 0"), kNewYear + 123'456'000);
  EXPECT_EQ(stamp_of("1704067200123456789", "time_ns: 0"), kNewYear + 123'456'789);
  EXPECT_EQ(stamp_of("1704067200123", "time: { column: 0, unit: ms, offset_s: -1704067200 }"), 123'000'000);
}

TEST_F(CsvTimes, UnixTimeInAnotherUnitIsNamedWhereItIsRefused) {
  EXPECT_THAT(
      error_of("1704067200123"),
      AllOf(HasSubstr("a.csv:1: \"1704067200123\" in column 0 counted from 0 (time) is out of range as seconds"),
            HasSubstr("unit: ms }")));
  EXPECT_THAT(error_of("1704067200123456"), HasSubstr("unit: us }"));
  EXPECT_THAT(error_of("1704067200123456789"), HasSubstr("unit: ns }"));
}

TEST_F(CsvTimes, SecondsAreNoNanoseconds) {
  const std::string error =
      "\"1717228800.31\" in column 0 counted from 0 (time) is 1.7 s after 1970 as ns; as s since 1970 it lies in this "
      "century: time: { column, unit: s }";
  for (const char* time : {"time_ns: 0", "time: { column: 0, unit: ns }", "time: { column: 0, scale: 1e-9 }"})
    EXPECT_THAT(error_of("1717228800.31", time), HasSubstr(error)) << time;
  // what a log that begins at 0 has after 1.7 s
  EXPECT_EQ(stamp_of("1717228800", "time_ns: 0"), 1'717'228'800);
  EXPECT_EQ(stamp_of("1717228800.0", "time_ns: 0"), 1'717'228'800);
  EXPECT_EQ(stamp_of("17228800.5", "time_ns: 0"), 17'228'801);
}

TEST_F(CsvTimes, DatesOfIso8601AreRead) {
  EXPECT_EQ(stamp_of("2024-01-01T00:00:00Z"), kNewYear);
  EXPECT_EQ(stamp_of("2024-01-01 00:00:00.25"), kNewYear + 250'000'000);
  EXPECT_EQ(stamp_of("2024-01-01T00:00:00.1234567896"), kNewYear + 123'456'790);
  EXPECT_EQ(stamp_of("2024-01-01T02:00:01+02:00"), kNewYear + 1'000'000'000);
  EXPECT_EQ(stamp_of("2023-12-31T18:30-0530"), kNewYear);
  EXPECT_EQ(stamp_of("2024-01-01T00:00:00Z", "time: { column: 0, offset_s: 0.5 }"), kNewYear + 500'000'000);
  EXPECT_EQ(stamp_of("2024-02-29T00:00:00+00"), kNewYear + 59 * 86'400'000'000'000);
}

TEST_F(CsvTimes, DatesThatAreNoneAreNamed) {
  for (const std::string text :
       {"2023-02-29T00:00:00Z", "2024-01-01T24:00:00Z", "2024-01-01T00:00:60Z", "2024-01-01T00:00:00X", "2024-01-01",
        "2024-13-01T00:00:00", "2024-01-01T00:00:00+24:00", "2024-01-01T00:00:00.Z", "1204-01-01T00:00:00Z"}) {
    EXPECT_THAT(error_of(text), AllOf(HasSubstr("a.csv:1: \"" + text), HasSubstr("ISO 8601"))) << text;
  }
  EXPECT_THAT(error_of("2024-01-01T00:00:00Z", "time_ms: 0"), HasSubstr("is a date: it has no unit or scale"));
}

TEST_F(CsvTimes, AUnitIsGivenOnce) {
  write("a.csv", "0,1,1\n");
  EXPECT_THAT(construction_error<ConfigError>(entry("time: { column: 0, unit: ms, scale: 1e-3 }")),
              HasSubstr("give either unit or scale"));
  EXPECT_THAT(construction_error<ConfigError>(entry("time_ms: { column: 0, unit: ms }")),
              HasSubstr("time_ms names the unit already"));
  EXPECT_THAT(construction_error<ConfigError>(entry("time: { column: 0, unit: m }")), HasSubstr("s, ms, us, ns"));
  EXPECT_THAT(construction_error<ConfigError>(entry("time: 0, time_ms: 0")), HasSubstr("give either time or time_ms"));
}

TEST_F(CsvTimes, ArrivalsHaveUnitsToo) {
  write("a.csv", "1000,1,1,2024-01-01T00:00:00Z\n");
  const auto measurement = make(wheels_yaml("a.csv", ", arrival: 3", "max_time_jump_s: 9e9\n"))->next();
  EXPECT_EQ(measurement->arrival.time_since_epoch().count(), kNewYear);
}

class CsvIntervals : public CsvTest {
 protected:
  struct Read {
    double stamp_s;
    double arrival_s;
  };
  std::vector<Measurement> read(const std::string& more) const {
    return read_all(*make("max_bad_rows: 1\nfiles: [{ path: a.csv, sensor: wheels, time: 0, " + more + " }]"));
  }
  static double seconds(Time time) { return to_seconds(time.time_since_epoch()); }
};

TEST_F(CsvIntervals, AMotionThatEndsAtItsStampBeginsBefore) {
  write("a.csv", "1,0.2,0.1,0,0\n1.5,0.25,0.1,0,0\n");
  const auto motions = read(
      "payload: PoseIncrement, end_of_interval: true,"
      " columns: { interval_s: 1, x_m: 2, y_m: 3, yaw_rad: 4 }");
  ASSERT_EQ(motions.size(), 2u);
  EXPECT_DOUBLE_EQ(seconds(motions[0].stamp), 0.8);
  EXPECT_EQ(seconds(motions[0].arrival), 1.0);
  EXPECT_EQ(seconds(motions[1].stamp), 1.25);
}

TEST_F(CsvIntervals, AMotionWithoutLengthBeginsAtTheRowBefore) {
  write("a.csv", "1,0.1,0,0\n1.5,0.2,0,0\n1.6,bad,0,0\n1.75,0.3,0,0\n");
  const auto motions = read(
      "payload: PoseIncrement, end_of_interval: true,"
      " columns: { x_m: 1, y_m: 2, yaw_rad: 3 }");
  ASSERT_EQ(motions.size(), 2u);
  EXPECT_EQ(seconds(motions[0].stamp), 1.0);
  EXPECT_EQ(motions[0].as<PoseIncrement>().interval_s, 0.5);
  EXPECT_EQ(motions[0].as<PoseIncrement>().x_m, 0.2);
  EXPECT_DOUBLE_EQ(seconds(motions[1].stamp), 1.6);  // not at the row before the bad one
  EXPECT_THAT(motions[1].as<PoseIncrement>().interval_s, DoubleNear(0.15, 1e-12));
}

TEST_F(CsvIntervals, AMeanSpeedIsTrueInTheMiddle) {
  write("a.csv", "1,1,1\n1.5,2,2\n2.5,3,3\n");
  const auto speeds = read("payload: WheelSpeeds, end_of_interval: true, columns: { left_mps: 1, right_mps: 2 }");
  ASSERT_EQ(speeds.size(), 2u);
  EXPECT_EQ(seconds(speeds[0].stamp), 1.25);
  EXPECT_EQ(seconds(speeds[0].arrival), 1.5);
  EXPECT_EQ(seconds(speeds[1].stamp), 2.0);
  EXPECT_EQ(speeds[1].as<WheelSpeeds>().left_mps, 3.0);
}

TEST_F(CsvIntervals, TheLastBeamOfAScanIsAtTheStamp) {
  write("a.csv", "1,5,5,5\n");
  const auto scans = read_all(*make(
      "files: [{ path: a.csv, sensor: lidar, time: 0, payload: LaserScan, end_of_interval: true,"
      " columns: { ranges_m: { first: 1, count: 3 } }, scan: { start_deg: 0, step_deg: 1, beam_interval_s: 0.1 } }]"));
  EXPECT_DOUBLE_EQ(seconds(scans.at(0).stamp), 0.8);
  EXPECT_EQ(seconds(scans.at(0).arrival), 1.0);
}

TEST_F(CsvIntervals, WhatHasNoIntervalIsRefused) {
  write("a.csv", "1,5,5,5\n1,5,5,5\n");
  const auto error = [this](const std::string& more) {
    return construction_error<ConfigError>("files: [{ path: a.csv, sensor: wheels, time: 0, end_of_interval: true, " +
                                           more + " }]");
  };
  EXPECT_THAT(error("payload: Height, columns: { height_m: 1 }"), HasSubstr("describe an instant"));
  EXPECT_THAT(error("payload: WheelSpeeds, columns: { left_mps: 1, right_mps: 2 }, cumulative: true"),
              HasSubstr("cannot be combined with cumulative"));
  EXPECT_THAT(
      reading_error(*make("files: [{ path: a.csv, sensor: wheels, time: 0, end_of_interval: true, payload: WheelSpeeds,"
                          " columns: { left_mps: 1, right_mps: 2 } }]")),
      HasSubstr("a.csv:2: no time has passed since the row before"));
}

}  // namespace
}  // namespace waymark
