// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "unit/plugins/sources/csv/csv_fixture.hpp"

namespace waymark {
namespace {

using csv_test::CsvTest;
using csv_test::gzip;
using csv_test::wheels_yaml;
using ::testing::ElementsAre;
using ::testing::FloatEq;

std::vector<std::int64_t> stamps_ns(const std::vector<Measurement>& all) {
  std::vector<std::int64_t> result;
  for (const Measurement& one : all) result.push_back(one.stamp.time_since_epoch().count());
  return result;
}

TEST_F(CsvTest, ReadsMappedColumns) {
  write("a.csv", "0.5,1.25,-2.5\n0.6,+1e1,3\n");
  const auto source = make(wheels_yaml("a.csv"));
  const auto all = read_all(*source);
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].as<WheelSpeeds>().left_mps, 1.25);
  EXPECT_EQ(all[0].as<WheelSpeeds>().right_mps, -2.5);
  EXPECT_EQ(all[1].as<WheelSpeeds>().left_mps, 10.0);
  EXPECT_THAT(stamps_ns(all), ElementsAre(500'000'000, 600'000'000));
  EXPECT_EQ(all[1].arrival, all[1].stamp);
  EXPECT_EQ(all[1].sequence, 1u);
}

TEST_F(CsvTest, DeliversOneChannelPerSensor) {
  write("a.csv", "0,1,2\n");
  const auto source = make(wheels_yaml("a.csv"));
  ASSERT_EQ(source->channels().size(), 1u);
  EXPECT_EQ(source->channels()[0].sensor, "wheels");
  EXPECT_EQ(source->channels()[0].payload_type, WheelSpeeds::kType);
}

TEST_F(CsvTest, AppliesScaleAndOffset) {
  write("a.csv", "0,10,2\n");
  const auto source = make(
      "files: [{path: a.csv, sensor: wheels, payload: WheelSteering, time: 0, columns: {speed_mps: {column: 1, scale: "
      "0.1, offset: -3}, steering_rad: 2}}]");
  const auto measurement = source->next();
  EXPECT_DOUBLE_EQ(measurement->as<WheelSteering>().speed_mps, -2.0);
  EXPECT_EQ(measurement->as<WheelSteering>().steering_rad, 2.0);
}

TEST_F(CsvTest, FindsColumnsByHeaderName) {
  write("a.csv", "right,t_s,left\n7,0.25,5\n");
  const auto source = make(
      "files: [{path: a.csv, sensor: wheels, payload: WheelSpeeds, time: {column: t_s}, columns: {left_mps: left, "
      "right_mps: {column: right}}}]");
  const auto measurement = source->next();
  EXPECT_EQ(measurement->as<WheelSpeeds>().left_mps, 5.0);
  EXPECT_EQ(measurement->as<WheelSpeeds>().right_mps, 7.0);
}

TEST_F(CsvTest, SkipsStatedHeaderRowsCommentsAndBlankLines) {
  write("a.csv", "1,1,1\n2,2,2\n% note\n\n3,3,3\n   \n4,4,4\n");
  const auto source = make(wheels_yaml("a.csv", ", header_rows: 2, comment: '%'"));
  EXPECT_THAT(stamps_ns(read_all(*source)), ElementsAre(3'000'000'000, 4'000'000'000));
}

struct Layout {
  const char* name;
  const char* content;
  const char* delimiter;
};
class CsvDelimiter : public CsvTest, public ::testing::WithParamInterface<Layout> {};

TEST_P(CsvDelimiter, IsGuessedOrGiven) {
  write("a.txt", GetParam().content);
  for (const bool given : {false, true}) {
    const auto source = make(wheels_yaml("a.txt", given ? std::string(", delimiter: ") + GetParam().delimiter : ""));
    const auto all = read_all(*source);
    ASSERT_EQ(all.size(), 2u);
    EXPECT_EQ(all[1].as<WheelSpeeds>().left_mps, 5.5);
    EXPECT_EQ(all[1].as<WheelSpeeds>().right_mps, -6.0);
  }
}

INSTANTIATE_TEST_SUITE_P(Files, CsvDelimiter,
                         ::testing::Values(Layout{"comma", "1,2,3\n4, 5.5 ,-6\n", "','"},
                                           Layout{"semicolon", "t;l;r\n1;2;3\n4;5.5;-6", "';'"},
                                           Layout{"tab", "1\t2\t3\n4\t5.5\t-6\n", "tab"},
                                           Layout{"blanks", "  1 \t 2 3\n 4\t5.5   -6  \n", "space"},
                                           Layout{"windows",
                                                  "\xEF\xBB\xBF\"t\",\"l\",\"r\"\r\n\"1\",2,3\r\n4,5.5,-6\r\n", "','"}),
                         [](const auto& test) { return test.param.name; });

TEST_F(CsvTest, ReadsGzipLikePlain) {
  const std::string text = "0,1,2\n1,3,4\n2,5,6\n";
  write("plain", text);
  write("packed", gzip(text, 4));
  write("two_members", gzip(text.substr(0, 8)) + gzip(text.substr(8)));
  for (const std::string name : {"plain", "packed", "two_members"}) {
    const auto source = make(wheels_yaml(name));
    const auto all = read_all(*source);
    ASSERT_EQ(all.size(), 3u) << name;
    EXPECT_EQ(all[2].as<WheelSpeeds>().right_mps, 6.0) << name;
  }
}

TEST_F(CsvTest, KeepsEveryDigitOfUnixTime) {
  write("a.csv", "1248446189.123456789,1,1\n1248446189.1234567896,1,1\n1.248446190e9,1,1\n");
  const auto source = make(wheels_yaml("a.csv"));
  EXPECT_THAT(stamps_ns(read_all(*source)), ElementsAre(1248446189123456789, 1248446189123456790, 1248446190000000000));
}

TEST_F(CsvTest, KeepsEveryDigitOfScaledTime) {
  write("a.csv", "1248446189123456789,1,1\n");
  const std::string head =
      "files: [{path: a.csv, sensor: wheels, payload: WheelSpeeds, columns: {left_mps: 1, right_mps: 2}, ";
  EXPECT_THAT(stamps_ns(read_all(*make(head + "time: {column: 0, scale: 1.0e-9}}]"))),
              ElementsAre(1248446189123456789));
  EXPECT_THAT(stamps_ns(read_all(*make(head + "time: {column: 0, scale: 1e-9, offset_s: -1248446189.1}}]"))),
              ElementsAre(23456789));
  write("a.csv", "-1500.0625,1,1\n");
  EXPECT_THAT(stamps_ns(read_all(*make(head + "time: {column: 0, scale: 0.001}}]"))), ElementsAre(-1500062500));
  EXPECT_THAT(stamps_ns(read_all(*make(head + "time: {column: 0, scale: 0.5}}]"))), ElementsAre(-750031250000));
}

TEST_F(CsvTest, MergesFilesByTime) {
  write("a.csv", "1,0,0\n3,0,0\n5,0,0\n");
  write("b.csv", "0,0,0\n3,0,0\n4,0,0\n");
  const auto source = make(
      "files:\n"
      "  - {path: a.csv, sensor: wheels, payload: WheelSpeeds, time: 0, columns: {left_mps: 1, right_mps: 2}}\n"
      "  - {path: b.csv, sensor: other, payload: WheelSpeeds, time: 0, columns: {left_mps: 1, right_mps: 2}}\n");
  std::string order;
  std::uint64_t sequence = 0;
  for (const Measurement& one : read_all(*source)) {
    order += source->channels().at(one.sensor).sensor[0];
    EXPECT_EQ(one.sequence, sequence++);
  }
  EXPECT_EQ(order, "owwoow");
}

TEST_F(CsvTest, TwoFilesCanFeedOneSensor) {
  write("a.csv", "1,0,0\n");
  write("b.csv", "0,0,0\n");
  const auto source = make(
      "files:\n"
      "  - {path: a.csv, sensor: wheels, payload: WheelSpeeds, time: 0, columns: {left_mps: 1, right_mps: 2}}\n"
      "  - {path: b.csv, sensor: wheels, payload: WheelSpeeds, time: 0, columns: {left_mps: 1, right_mps: 2}}\n");
  EXPECT_EQ(source->channels().size(), 1u);
  EXPECT_THAT(stamps_ns(read_all(*source)), ElementsAre(0, 1'000'000'000));
}

TEST_F(CsvTest, OrdersByArrivalIfThatIsMapped) {
  write("a.csv", "2.0,1,1,2.1\n1.0,2,2,2.2\n");
  const auto source = make(wheels_yaml("a.csv", ", arrival: 3"));
  const auto all = read_all(*source);
  EXPECT_THAT(stamps_ns(all), ElementsAre(2'000'000'000, 1'000'000'000));
  EXPECT_EQ(all[1].arrival, Time{Duration{2'200'000'000}});
}

TEST_F(CsvTest, KeepsTheRowsThatSatisfyAllConditions) {
  write("a.csv", "0,1,9\n1,2,9\n2,3,9\n3,4,8\n4,5,9\n");
  const auto kept = [this](const std::string& where) {
    return stamps_ns(read_all(*make(wheels_yaml("a.csv", ", where: [" + where + "]")))).size();
  };
  EXPECT_EQ(kept("{column: 1, in: [1, 2, 4]}"), 3u);
  EXPECT_EQ(kept("{column: 1, not_in: [1]}"), 4u);
  EXPECT_EQ(kept("{column: 2, equals: 9}"), 4u);
  EXPECT_EQ(kept("{column: 1, min: 2, max: 4}"), 3u);
  EXPECT_EQ(kept("{column: 1, min: 2, max: 4}, {column: 2, equals: 9}"), 2u);
}

TEST_F(CsvTest, ThinsOutRowsThatFollowTooSoon) {
  write("a.csv", "0,1,9\n0.04,2,9\n0.05,3,9\n0.09,4,8\n0.3,5,9\n");
  const auto all = read_all(*make(wheels_yaml("a.csv", ", min_step_s: 0.05")));
  EXPECT_THAT(stamps_ns(all), ElementsAre(0, 50'000'000, 300'000'000));
}

TEST_F(CsvTest, ReadsTwistWithoutSidewaysSpeed) {
  write("a.csv", "0 0.1 -0.2\n");
  const auto source =
      make("files: [{path: a.csv, sensor: wheels, payload: BodyTwist, time: 0, columns: {v_x_mps: 1, w_z_radps: 2}}]");
  const auto measurement = source->next();
  EXPECT_EQ(measurement->as<BodyTwist>().v_x_mps, 0.1);
  EXPECT_EQ(measurement->as<BodyTwist>().v_y_mps, 0.0);
  EXPECT_EQ(measurement->as<BodyTwist>().w_z_radps, -0.2);
}

TEST_F(CsvTest, ReadsGnssFixes) {
  write("a.csv", "0,47.5,8.5,400,1.5,3,0.9,12,4\n1,47.5,8.5,400,1.5,3,0.9,12,77\n");
  const auto source = make(
      "files: [{path: a.csv, sensor: gps, payload: GnssFix, time: 0, columns: {latitude_deg: 1, longitude_deg: 2, "
      "height_m: 3, sigma_horizontal_m: 4, sigma_vertical_m: 5, hdop: 6, satellites: 7, type: {column: 8, map: {1: "
      "single, 4: rtk_fixed}}}}]");
  const auto all = read_all(*source);
  ASSERT_EQ(all.size(), 2u);
  const auto& fix = all[0].as<GnssFix>();
  EXPECT_EQ(fix.latitude_deg, 47.5);
  EXPECT_EQ(fix.longitude_deg, 8.5);
  EXPECT_EQ(fix.height_m, 400.0);
  EXPECT_EQ(fix.sigma_horizontal_m, 1.5);
  EXPECT_EQ(fix.sigma_vertical_m, 3.0);
  EXPECT_EQ(fix.hdop, 0.9);
  EXPECT_EQ(fix.satellites, 12);
  EXPECT_EQ(fix.type, GnssFix::Type::rtk_fixed);
  EXPECT_TRUE(std::isnan(fix.p_map_antenna.x()));
  EXPECT_EQ(all[1].as<GnssFix>().type, GnssFix::Type::unknown);
}

TEST_F(CsvTest, ReadsLocalFixesInAnyColumnOrder) {
  write("a.csv", "0,10,20\n");
  const auto source =
      make("files: [{path: a.csv, sensor: gps, payload: GnssFix, time: 0, columns: {north_m: 1, east_m: 2}}]");
  const auto measurement = source->next();
  EXPECT_EQ(measurement->as<GnssFix>().p_map_antenna.x(), 20.0);
  EXPECT_EQ(measurement->as<GnssFix>().p_map_antenna.y(), 10.0);
  EXPECT_TRUE(std::isnan(measurement->as<GnssFix>().p_map_antenna.z()));
}

TEST_F(CsvTest, ReadsScansFromColumnRanges) {
  write("a.csv", "t,r0,r1,r2,i0,i1,i2\n0,100,200,300,1,0,2\n");
  const auto source = make(
      "files: [{path: a.csv, sensor: lidar, payload: LaserScan, time: t, columns: {ranges_m: {first: r0, last: r2, "
      "scale: 0.01}, intensities: {first: 4, count: 3}}, scan: {start_deg: -90, step_deg: 0.5}}]");
  const auto measurement = source->next();
  const auto& scan = measurement->as<LaserScan>();
  EXPECT_THAT(scan.ranges_m, ElementsAre(FloatEq(1), FloatEq(2), FloatEq(3)));
  EXPECT_THAT(scan.intensities, ElementsAre(1, 0, 2));
  EXPECT_DOUBLE_EQ(scan.start_rad, -std::numbers::pi / 2);
  EXPECT_DOUBLE_EQ(scan.step_rad, std::numbers::pi / 360);
}

TEST_F(CsvTest, NonFiniteBeamsAreNoReturnIfAllowed) {
  write("a.csv", "0,1,inf,nan\n");
  const auto source = make(
      "files: [{path: a.csv, sensor: lidar, payload: LaserScan, time: 0, columns: {ranges_m: {first: 1, count: 3}}, "
      "scan: {start_deg: 0, step_deg: 1, allow_non_finite: true}}]");
  const auto measurement = source->next();
  const float infinity = std::numeric_limits<float>::infinity();
  EXPECT_THAT(measurement->as<LaserScan>().ranges_m, ElementsAre(1.0F, infinity, infinity));
}

const std::string kCamera =
    "files: [{path: a.csv, sensor: camera, payload: LandmarkObservations, time: 0, columns: {range_m: 1, bearing_rad: "
    "2, identity: 3}";

TEST_F(CsvTest, GroupsRowsOfEqualStamp) {
  write("a.csv", "0,1,0.1,7\n0,2,0.2,8\n1,3,0.3,9\n2,4,0.4,5\n2,5,0.5,6\n");
  const auto source = make(kCamera + ", group_by_time: true}]");
  const auto all = read_all(*source);
  ASSERT_EQ(all.size(), 3u);
  ASSERT_EQ(all[0].as<LandmarkObservations>().landmarks.size(), 2u);
  EXPECT_EQ(all[1].as<LandmarkObservations>().landmarks.size(), 1u);
  EXPECT_EQ(all[2].as<LandmarkObservations>().landmarks.size(), 2u);
  const auto& second = all[0].as<LandmarkObservations>().landmarks[1];
  EXPECT_EQ(second.range_m, 2.0);
  EXPECT_EQ(second.bearing_rad, 0.2);
  EXPECT_EQ(second.identity, 8);
  EXPECT_TRUE(std::isnan(second.radius_m));
}

TEST_F(CsvTest, WithoutGroupingEveryRowIsASet) {
  write("a.csv", "0,1,0.1,7\n0,2,0.2,8\n");
  const auto all = read_all(*make(kCamera + "}]"));
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[1].as<LandmarkObservations>().landmarks.at(0).identity, 8);
}

TEST_F(CsvTest, ABadRowDoesNotBreakItsGroup) {
  write("a.csv", "0,1,0.1,7\n0,x,0.2,8\n0,3,0.3,9\n");
  const auto source = make("max_bad_rows: 1\n" + kCamera + ", group_by_time: true}]");
  const auto all = read_all(*source);
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].as<LandmarkObservations>().landmarks.size(), 2u);
  EXPECT_EQ(source->bad_records().size(), 1u);
}

TEST_F(CsvTest, ValuesThatBreakARuleOfThePayloadAreABadRow) {
  write("a.csv", "0,1,0.1,7\n0,-2,0.2,8\n1,-3,0.3,9\n");
  const auto source = make("max_bad_rows: 2\n" + kCamera + ", group_by_time: true}]");
  const auto all = read_all(*source);
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].as<LandmarkObservations>().landmarks.size(), 1u);
  ASSERT_EQ(source->bad_records().size(), 2u);
  EXPECT_EQ(source->bad_records()[0].reason, "a landmark's range is negative");
}

TEST_F(CsvTest, WhatABadRowEndsIsDeliveredBeforeIt) {
  write("a.csv", "0,1,0.1,7\n1,2,0.2,8\n1,3,0.3,9\n2,x,0.3,9\n");
  const auto source = make(kCamera + ", group_by_time: true}]");
  EXPECT_EQ(source->next()->as<LandmarkObservations>().landmarks.size(), 1u);
  const auto last = source->next();
  ASSERT_TRUE(last);
  EXPECT_EQ(last->as<LandmarkObservations>().landmarks.size(), 2u) << "the set was complete";
  EXPECT_THROW(source->next(), DataError);
}

TEST_F(CsvTest, ReadsTheReference) {
  write("a.csv", "0,1,2\n");
  write("truth.txt", "# t x y yaw\n10.5 1 2 0.5\n11.5 3 4 0.6\n");
  write("survey.csv", "id,x,y\nB 1,1.5,2.5\n");
  const auto source = make(wheels_yaml("a.csv") +
                           "reference:\n"
                           "  trajectory: {path: truth.txt, columns: {time: 0, x_m: 1, y_m: 2, yaw_rad: 3}}\n"
                           "  landmarks: {path: survey.csv, columns: {name: id, x_m: x, y_m: y}}\n");
  const auto reference = source->reference();
  ASSERT_TRUE(reference);
  ASSERT_EQ(reference->trajectory.size(), 2u);
  EXPECT_EQ(reference->trajectory[1].stamp, Time{Duration{11'500'000'000}});
  EXPECT_EQ(reference->trajectory[1].T_map_base.p.x(), 3.0);
  EXPECT_NEAR(reference->trajectory[1].T_map_base.yaw(), 0.6, 1e-12);
  EXPECT_TRUE(reference->trajectory[1].has_yaw);
  ASSERT_EQ(reference->landmarks.size(), 1u);
  EXPECT_EQ(reference->landmarks[0].name, "B 1");
  EXPECT_EQ(reference->landmarks[0].p_map.y(), 2.5);
  EXPECT_TRUE(std::isnan(reference->landmarks[0].radius_m));
}

TEST_F(CsvTest, HasNoReferenceUnlessAsked) {
  write("a.csv", "0,1,2\n");
  EXPECT_EQ(make(wheels_yaml("a.csv"))->reference(), nullptr);
}

TEST_F(CsvTest, ProgressReachesOne) {
  write("a.csv", gzip("0,1,2\n1,1,2\n"));
  const auto source = make(wheels_yaml("a.csv"));
  read_all(*source);
  EXPECT_DOUBLE_EQ(source->progress(), 1.0);
}

TEST_F(CsvTest, ProgressIsThatOfTheRowsNotOfWhatIsReadAhead) {
  std::string rows;
  for (int i = 100; i < 400; ++i) rows += std::to_string(i) + ",1,2\n";  // less than a buffer
  for (const std::string& content : {rows, gzip(rows)}) {
    write("a.csv", content);
    const auto source = make(wheels_yaml("a.csv"));
    for (int i = 0; i < 75; ++i) source->next();
    EXPECT_NEAR(source->progress(), 0.25, 0.01);
  }
}

}  // namespace
}  // namespace waymark
