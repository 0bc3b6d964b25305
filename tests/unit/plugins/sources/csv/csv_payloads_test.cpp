// SPDX-License-Identifier: Apache-2.0
// Payloads of IMU, compass and camera, values that are unknown, and angles in radians.
#include <gmock/gmock.h>

#include <cmath>

#include "unit/plugins/sources/csv/csv_fixture.hpp"

namespace waymark {
namespace {

using csv_test::CsvTest;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class CsvPayloads : public CsvTest {
 protected:
  /// A source of one file, a.csv, with the time in column t.
  std::shared_ptr<Source> source(const std::string& more, const std::string& more_of_the_source = "") const {
    return make(entry(more, more_of_the_source));
  }
  static std::string entry(const std::string& more, const std::string& more_of_the_source = "") {
    return more_of_the_source + "files: [{ path: a.csv, sensor: camera, time: t, " + more + " }]";
  }
};

const std::string kNineAxes =
    "payload: ImuSample, columns: { w_x_radps: wx, w_y_radps: wy, w_z_radps: wz, f_x_mps2: fx, f_y_mps2: fy,"
    " f_z_mps2: fz, m_x_t: mx, m_y_t: my, m_z_t: mz }";

TEST_F(CsvPayloads, ReadsNineAxes) {
  write("a.csv", "t,wx,wy,wz,fx,fy,fz,mx,my,mz\n0,1,2,3,4,5,6,7e-6,8e-6,-9e-6\n");
  const auto measurement = source(kNineAxes)->next();
  const auto& sample = measurement->as<ImuSample>();
  EXPECT_EQ(sample.w_sensor, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(sample.f_sensor, Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(sample.m_sensor, Eigen::Vector3d(7e-6, 8e-6, -9e-6));
}

TEST_F(CsvPayloads, ReadsAGyroscopeAlone) {
  write("a.csv", "t,wx,wy,wz\n0,1,2,3\n");
  const auto measurement =
      source("payload: ImuSample, columns: { w_x_radps: wx, w_y_radps: wy, w_z_radps: wz }")->next();
  const auto& sample = measurement->as<ImuSample>();
  EXPECT_EQ(sample.w_sensor, Eigen::Vector3d(1, 2, 3));
  EXPECT_TRUE(sample.f_sensor.array().isNaN().all());
  EXPECT_TRUE(sample.m_sensor.array().isNaN().all());
}

TEST_F(CsvPayloads, RefusesHalfAnAccelerometer) {
  write("a.csv", "t,wx,wy,wz,fx\n0,1,2,3,4\n");
  EXPECT_THAT(construction_error<ConfigError>(
                  entry("payload: ImuSample, columns: { w_x_radps: wx, w_y_radps: wy, w_z_radps: wz, f_x_mps2: fx }")),
              HasSubstr("\"f_x_mps2\", \"f_y_mps2\" and \"f_z_mps2\", or none of them"));
  EXPECT_THAT(construction_error<ConfigError>(entry("payload: ImuSample, columns: { w_x_radps: wx }")),
              HasSubstr("ImuSample needs the column \"w_y_radps\""));
}

TEST_F(CsvPayloads, ReadsACompass) {
  write("a.csv", "t,deg\n0,90\n");
  const auto measurement =
      source("payload: CompassHeading, columns: { heading_rad: { column: deg, scale: 0.0174532925199433 } }")->next();
  EXPECT_NEAR(measurement->as<CompassHeading>().heading_rad, 1.5707963, 1e-6);
}

TEST_F(CsvPayloads, ACompassMayKnowTrueNorthAndItsDoubt) {
  write("a.csv", "t,h,s,true_north\n0,1,0.1,1\n1,2,,0\n2,3,,2\n");
  const std::string columns =
      "payload: CompassHeading, empty_is_unknown: true, columns: { heading_rad: h, sigma_rad: s";
  const auto by_column = source(columns + ", from_true_north: true_north }", "max_bad_rows: 1\n");
  const auto all = read_all(*by_column);
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].as<CompassHeading>().sigma_rad, 0.1);
  EXPECT_TRUE(all[0].as<CompassHeading>().from_true_north);
  EXPECT_TRUE(std::isnan(all[1].as<CompassHeading>().sigma_rad));
  EXPECT_FALSE(all[1].as<CompassHeading>().from_true_north);
  EXPECT_THAT(by_column->bad_records().at(0).reason,
              HasSubstr("\"2\" in column \"true_north\" (from_true_north) is neither 0 nor 1"));
  EXPECT_TRUE(source(columns + ", from_true_north: true }")->next()->as<CompassHeading>().from_true_north);
  EXPECT_FALSE(source(columns + " }")->next()->as<CompassHeading>().from_true_north);
}

TEST_F(CsvPayloads, ReadsAFieldAndAHeight) {
  write("a.csv", "t,x,y,z\n0,10,-20,30\n");
  const auto micro = [](const char* axis) { return std::string("{ column: ") + axis + ", scale: 1e-6 }"; };
  const auto field = source("payload: MagneticField, columns: { m_x_t: " + micro("x") + ", m_y_t: " + micro("y") +
                            ", m_z_t: " + micro("z") + " }")
                         ->next();
  EXPECT_TRUE(field->as<MagneticField>().m_sensor.isApprox(Eigen::Vector3d(1e-5, -2e-5, 3e-5)));
  const auto height = source("payload: Height, columns: { height_m: x, sigma_m: z }")->next();
  EXPECT_EQ(height->as<Height>().height_m, 10.0);
  EXPECT_EQ(height->as<Height>().sigma_m, 30.0);
  EXPECT_THAT(construction_error<ConfigError>(entry("payload: MagneticField, columns: { m_x_t: x, m_y_t: y }")),
              HasSubstr("MagneticField needs the column \"m_z_t\""));
}

TEST_F(CsvPayloads, ReadsTheVelocityOfAFix) {
  write("a.csv", "t,lat,lon,kmh,deg\n0,51,13,36,90\n");
  const auto measurement = source(
                               "payload: GnssFix, columns: { latitude_deg: lat, longitude_deg: lon,"
                               " speed_mps: { column: kmh, scale: 0.2777777777777778 },"
                               " course_rad: { column: deg, scale: 0.0174532925199433 } }")
                               ->next();
  EXPECT_NEAR(measurement->as<GnssFix>().speed_mps, 10.0, 1e-12);
  EXPECT_NEAR(measurement->as<GnssFix>().course_rad, 1.5707963, 1e-6);
}

TEST_F(CsvPayloads, RepeatedFixesAreOne) {
  write("a.csv", "t,lat,lon,x\n0,51,13,1\n1,51,13,2\n2,51,14,3\n3,51,14,4\n4,52,14,5\n5,51,14,6\n");
  const std::string columns = "payload: GnssFix, columns: { latitude_deg: lat, longitude_deg: lon, hdop: x }";
  const auto fixes = source(columns + ", only_changes_of: [lat, lon]");
  std::vector<double> first_of_each;
  for (const Measurement& m : read_all(*fixes)) first_of_each.push_back(m.as<GnssFix>().hdop);
  EXPECT_THAT(first_of_each, ::testing::ElementsAre(1, 3, 5, 6));
  EXPECT_EQ(read_all(*source(columns + ", only_changes_of: lat")).size(), 3u);
  EXPECT_THAT(construction_error<ConfigError>(entry(columns + ", only_changes_of: [lat, long]")),
              HasSubstr("the header has no column \"long\""));
}

TEST_F(CsvPayloads, ABadRowDoesNotHideItsRepetitions) {
  write("a.csv", "t,lat,lon,x\n0,51,13,1\n1,51,14,bad\n2,51,14,3\n3,51,14,4\n");
  const auto fixes = source(
      "payload: GnssFix, columns: { latitude_deg: lat, longitude_deg: lon, hdop: x }, "
      "only_changes_of: [lat, lon]",
      "max_bad_rows: 1\n");
  std::vector<double> read;
  for (const Measurement& m : read_all(*fixes)) read.push_back(m.as<GnssFix>().hdop);
  EXPECT_THAT(read, ::testing::ElementsAre(1, 3));
}

TEST_F(CsvPayloads, TotalsBecomeSpeeds) {
  write("a.csv", "t,l,r\n10,100,200\n10.5,150,200\n10.9,130,240\n");
  const std::string wheels =
      "payload: WheelSpeeds, columns: { left_mps: { column: l, scale: 0.01, offset: 7 },"
      " right_mps: { column: r, scale: 0.02 } }, cumulative: true";
  const auto speeds = read_all(*source(wheels));
  ASSERT_EQ(speeds.size(), 2u);
  EXPECT_NEAR(speeds[0].as<WheelSpeeds>().left_mps, 1.0, 1e-12);
  EXPECT_NEAR(speeds[0].as<WheelSpeeds>().right_mps, 0.0, 1e-12);
  EXPECT_NEAR(speeds[1].as<WheelSpeeds>().left_mps, -0.5, 1e-12);
  EXPECT_NEAR(speeds[1].as<WheelSpeeds>().right_mps, 2.0, 1e-12);
  EXPECT_EQ(speeds[1].stamp.time_since_epoch().count(), 10'700'000'000);
  EXPECT_EQ(speeds[1].arrival.time_since_epoch().count(), 10'900'000'000);
}

TEST_F(CsvPayloads, TicksOfTwoWheelsBecomeMotions) {
  write("a.csv", "t,l,r\n1,1000,500\n1.25,1000,700\n1.5,1100,800\n");
  const auto motions =
      read_all(*source("payload: PoseIncrement, cumulative: yes, track_m: 0.5,"
                       " columns: { left_m: { column: l, scale: 1e-3 }, right_m: { column: r, scale: 1e-3 } }"));
  ASSERT_EQ(motions.size(), 2u);
  const auto& turn = motions[0].as<PoseIncrement>();  // about the left wheel
  EXPECT_NEAR(turn.yaw_rad, 0.4, 1e-12);
  EXPECT_NEAR(turn.x_m, 0.25 * std::sin(0.4), 1e-12);
  EXPECT_NEAR(turn.y_m, 0.25 * (1.0 - std::cos(0.4)), 1e-12);
  EXPECT_NEAR(turn.interval_s, 0.25, 1e-12);
  EXPECT_EQ(motions[0].stamp.time_since_epoch().count(), 1'000'000'000);
  EXPECT_EQ(motions[0].arrival.time_since_epoch().count(), 1'250'000'000);
  const auto& straight = motions[1].as<PoseIncrement>();
  EXPECT_NEAR(straight.x_m, 0.1, 1e-12);
  EXPECT_NEAR(straight.y_m, 0.0, 1e-12);
  EXPECT_NEAR(straight.yaw_rad, 0.0, 1e-12);
}

TEST_F(CsvPayloads, PosesOfOdometryBecomeMotions) {
  write("a.csv", "t,x,y,a\n0,5,5,3\n2,5,6,-3\n");
  const auto motions =
      read_all(*source("payload: PoseIncrement, cumulative: true, columns: { x_m: x, y_m: y, yaw_rad: a }"));
  ASSERT_EQ(motions.size(), 1u);
  const auto& motion = motions[0].as<PoseIncrement>();
  EXPECT_NEAR(motion.x_m, std::sin(3.0), 1e-12);
  EXPECT_NEAR(motion.y_m, std::cos(3.0), 1e-12);
  EXPECT_NEAR(motion.yaw_rad, 2.0 * M_PI - 6.0, 1e-12);
  EXPECT_NEAR(motion.interval_s, 2.0, 1e-12);
}

TEST_F(CsvPayloads, RefusesHalfTurnsAndHalfAPairOfWheels) {
  write("a.csv", "t,l,r\n0,0,0\n1,0,1\n2,0,1.1\n");
  const std::string wheels = "payload: PoseIncrement, cumulative: true, columns: { left_m: l, right_m: r }";
  const auto spins = source(wheels + ", track_m: 0.3", "max_bad_rows: 1\n");
  EXPECT_EQ(read_all(*spins).size(), 1u);
  EXPECT_THAT(construction_error<ConfigError>(entry(wheels)), HasSubstr("track_m"));
  EXPECT_THAT(construction_error<ConfigError>(
                  entry("payload: PoseIncrement, cumulative: true, columns: { left_m: l }, track_m: 0.3")),
              HasSubstr("needs the column \"right_m\""));
  EXPECT_THAT(construction_error<ConfigError>(entry("payload: PoseIncrement, cumulative: { wraps_at: 9 }, columns: {"
                                                    " x_m: l, y_m: r, yaw_rad: r }")),
              HasSubstr("poses do not start over"));
}

TEST_F(CsvPayloads, TotalsMayStartOver) {
  write("a.csv", "t,l,r\n0,65530,3\n1,4,65533\n");
  const std::string wheels = "payload: WheelSpeeds, columns: { left_mps: { column: l, scale: -0.5 }, right_mps: r }";
  const auto wrapped = read_all(*source(wheels + ", cumulative: { wraps_at: 65536 }"));
  ASSERT_EQ(wrapped.size(), 1u);
  EXPECT_NEAR(wrapped[0].as<WheelSpeeds>().left_mps, -5.0, 1e-9);
  EXPECT_NEAR(wrapped[0].as<WheelSpeeds>().right_mps, -6.0, 1e-9);
}

TEST_F(CsvPayloads, TotalsOfOneTimeAreNoSpeed) {
  write("a.csv", "t,v,w\n0,1,0\n0,2,0\n1,3,0.5\n");
  const auto twists =
      source("payload: BodyTwist, columns: { v_x_mps: v, w_z_radps: w }, cumulative: true", "max_bad_rows: 1\n");
  const auto good = read_all(*twists);
  ASSERT_EQ(good.size(), 1u);
  EXPECT_NEAR(good[0].as<BodyTwist>().v_x_mps, 2.0, 1e-12);
  EXPECT_NEAR(good[0].as<BodyTwist>().w_z_radps, 0.5, 1e-12);
  const auto strict = source("payload: BodyTwist, columns: { v_x_mps: v, w_z_radps: w }, cumulative: true");
  EXPECT_THAT(reading_error(*strict), HasSubstr("a.csv:3: no time has passed since the row before"));
}

TEST_F(CsvPayloads, NotEveryPayloadHasTotals) {
  write("a.csv", "t,h\n0,1\n");
  EXPECT_THAT(construction_error<ConfigError>(entry("payload: Height, columns: { height_m: h }, cumulative: true")),
              HasSubstr("cumulative: this payload has no totals"));
  EXPECT_THAT(construction_error<ConfigError>(
                  entry("payload: WheelSpeeds, columns: { left_mps: h, right_mps: h }, cumulative: { wraps_at: 0 }")),
              HasSubstr("wraps_at"));
}

TEST_F(CsvPayloads, AnOrientationIsAUnitQuaternionOrUnknown) {
  write("a.csv", "t,x,y,z,w\n0,0,0.6,0,0.8\n1,0,0,0,0\n2,,,,\n3,0,0,0.7071,0.7071\n4,0,0,0,0.5\n");
  const std::string columns =
      "payload: ImuSample, empty_is_unknown: true, columns: { w_x_radps: t, w_y_radps: t, w_z_radps: t, q_w: w";
  const auto imu = source(columns + ", q_x: x, q_y: y, q_z: z }", "max_bad_rows: 1\n");
  const auto all = read_all(*imu);
  ASSERT_EQ(all.size(), 4u);
  EXPECT_EQ(all[0].as<ImuSample>().q_enu_sensor.coeffs(), Eigen::Vector4d(0.0, 0.6, 0.0, 0.8));
  EXPECT_TRUE(all[1].as<ImuSample>().q_enu_sensor.coeffs().array().isNaN().all());
  EXPECT_TRUE(all[2].as<ImuSample>().q_enu_sensor.coeffs().array().isNaN().all());
  EXPECT_NEAR(all[3].as<ImuSample>().q_enu_sensor.norm(), 1.0, 1e-15);
  EXPECT_THAT(imu->bad_records().at(0).reason, HasSubstr("not a unit quaternion"));
  EXPECT_THAT(construction_error<ConfigError>(entry(columns + " }")),
              HasSubstr("\"q_w\", \"q_x\", \"q_y\" and \"q_z\", or none of them"));
}

TEST_F(CsvPayloads, DeliversAnImagesFileAsItIs) {
  std::filesystem::create_directories(folder_ / "log" / "pictures");
  const std::string bytes("\x89PNG\0\r\n#\n,", 10);
  write("log/pictures/1.png", bytes);
  write("log/pictures/empty.png", "");
  write("log/a.csv", "t,file\n0.5,pictures/1.png\n1,pictures/empty.png\n");
  const auto all =
      read_all(*make("files: [{ path: log/a.csv, sensor: camera, time: t, payload: Image, columns: { file: file } }]"));
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].as<Image>().encoding, Image::Encoding::compressed);
  EXPECT_EQ(std::string(all[0].as<Image>().data.begin(), all[0].as<Image>().data.end()), bytes);
  EXPECT_THAT(all[1].as<Image>().data, IsEmpty());
}

TEST_F(CsvPayloads, AMissingImageIsABadRow) {
  write("there.jpg", "\xff\xd8");
  write("a.csv", "t,file\n0,there.jpg\n1,nowhere.jpg\n2,.\n3,\n4,there.jpg\n");
  const auto all = source("payload: Image, columns: { file: file }", "max_bad_rows: 3\n");
  EXPECT_EQ(read_all(*all).size(), 2u);
  const auto& bad = all->bad_records();
  ASSERT_EQ(bad.size(), 3u);
  EXPECT_EQ(bad[0].place, (folder_ / "a.csv").string() + ":3");
  EXPECT_THAT(bad[0].reason, AllOf(HasSubstr((folder_ / "nowhere.jpg").string()), HasSubstr("No such file")));
  EXPECT_THAT(bad[1].reason, HasSubstr("cannot be read"));
  EXPECT_THAT(bad[2].reason, HasSubstr("is empty"));
}

TEST_F(CsvPayloads, AnEmptyFieldIsUnknownIfTheFileSaysSo) {
  write("a.csv", "t,e,n,lat,lon,sat,kind\n0,1,2,,,,\n1,,,49,8,7,1\n");
  const std::string fix =
      "payload: GnssFix, columns: { east_m: e, north_m: n, latitude_deg: lat, longitude_deg: lon, satellites: sat }";
  const auto all = read_all(*source(fix + ", empty_is_unknown: true"));
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].as<GnssFix>().p_map_antenna.y(), 2.0);
  EXPECT_TRUE(std::isnan(all[0].as<GnssFix>().latitude_deg));
  EXPECT_EQ(all[0].as<GnssFix>().satellites, -1);
  EXPECT_TRUE(std::isnan(all[1].as<GnssFix>().p_map_antenna.x()));
  EXPECT_EQ(all[1].as<GnssFix>().latitude_deg, 49.0);
  EXPECT_EQ(all[1].as<GnssFix>().satellites, 7);
  EXPECT_THAT(reading_error(*source(fix)), HasSubstr("a.csv:2: column \"lat\" (latitude_deg) is empty"));
}

TEST_F(CsvPayloads, ARequiredFieldIsNeverUnknown) {
  write("a.csv", "t,h\n0,\n");
  EXPECT_THAT(reading_error(*source("payload: CompassHeading, columns: { heading_rad: h }, empty_is_unknown: true")),
              HasSubstr("column \"h\" (heading_rad) is empty"));
}

TEST_F(CsvPayloads, UnknownAxesAreNaN) {
  write("a.csv", "t,wx,wy,wz,fx,fy,fz,mx,my,mz\n0,1,2,3,4,5,6,,,\n");
  const auto measurement = source(kNineAxes + ", empty_is_unknown: true")->next();
  EXPECT_EQ(measurement->as<ImuSample>().f_sensor.z(), 6.0);
  EXPECT_TRUE(measurement->as<ImuSample>().m_sensor.array().isNaN().all());
}

TEST_F(CsvPayloads, AnOptionalNumberKeepsItsDefault) {
  write("a.csv", "t,vx,vy,w\n0,1,,3\n");
  const auto measurement =
      source("payload: BodyTwist, columns: { v_x_mps: vx, v_y_mps: vy, w_z_radps: w }, empty_is_unknown: true")->next();
  EXPECT_EQ(measurement->as<BodyTwist>().v_y_mps, 0.0);
}

TEST_F(CsvPayloads, ASetMayBeEmpty) {
  write("a.csv", "t,range,bearing,radius,id\n0,,,,\n1,2,0.5,,\n1,3,0.6,0.1,4\n2,,,,\n");
  const auto all =
      read_all(*source("payload: LandmarkObservations, group_by_time: true, empty_is_unknown: true,"
                       " columns: { range_m: range, bearing_rad: bearing, radius_m: radius, identity: id }"));
  ASSERT_EQ(all.size(), 3u);
  EXPECT_THAT(all[0].as<LandmarkObservations>().landmarks, IsEmpty());
  EXPECT_THAT(all[2].as<LandmarkObservations>().landmarks, IsEmpty());
  const auto& seen = all[1].as<LandmarkObservations>().landmarks;
  ASSERT_EQ(seen.size(), 2u);
  EXPECT_TRUE(std::isnan(seen[0].radius_m));
  EXPECT_EQ(seen[0].identity, -1);
  EXPECT_EQ(seen[1].radius_m, 0.1);
  EXPECT_EQ(seen[1].identity, 4);
}

TEST_F(CsvPayloads, RangesOfOneBurstAreASet) {
  write("a.csv", "t,beacon,range,minus\n1,0,2.5,-1\n1,5,-3,6\n2,1,4,-1\n");
  const auto all =
      read_all(*source("payload: Ranges, group_by_time: true,"
                       " columns: { beacon: beacon, range_m: range, reference: minus }"));
  ASSERT_EQ(all.size(), 2u);
  const auto& ranges = all[0].as<Ranges>().ranges;
  ASSERT_EQ(ranges.size(), 2u);
  EXPECT_EQ(ranges[1].beacon, 5);
  EXPECT_EQ(ranges[1].range_m, -3.0);
  EXPECT_EQ(ranges[1].reference, 6);
  EXPECT_TRUE(std::isnan(ranges[1].sigma_m));
  EXPECT_EQ(all[1].as<Ranges>().ranges.size(), 1u);
}

TEST_F(CsvPayloads, TargetsOfOneScanAreASet) {
  write("a.csv", "t,range_cm,azimuth,speed\n1,250,30,-4\n1,300,-30,5\n");
  const auto all =
      read_all(*source("payload: RadarTargets, group_by_time: true,"
                       " columns: { range_cm: range_cm, azimuth_deg: azimuth, radial_mps: speed }"));
  ASSERT_EQ(all.size(), 1u);
  const auto& targets = all[0].as<RadarTargets>().targets;
  ASSERT_EQ(targets.size(), 2u);
  EXPECT_DOUBLE_EQ(targets[0].range_m, 2.5);
  EXPECT_NEAR(targets[1].azimuth_rad, -0.5235987755982988, 1e-15);
  EXPECT_EQ(targets[1].radial_mps, 5.0);
  EXPECT_EQ(targets[1].elevation_rad, 0.0);
}

TEST_F(CsvPayloads, KeepsTheSignOfZero) {
  write("a.csv", "t,h\n0,-0\n");
  const auto measurement = source("payload: CompassHeading, columns: { heading_rad: h }")->next();
  EXPECT_TRUE(std::signbit(measurement->as<CompassHeading>().heading_rad));
}

TEST_F(CsvPayloads, TakesTheAnglesOfAScanInRadians) {
  write("a.csv", "t,r0,r1\n0,1,2\n");
  const std::string scan = "payload: LaserScan, columns: { ranges_m: { first: r0, count: 2 } }, scan: ";
  const auto measurement = source(scan + "{ start_rad: -2.356194490192345, step_rad: 0.008726646259971648 }")->next();
  EXPECT_EQ(measurement->as<LaserScan>().start_rad, -2.356194490192345);
  EXPECT_EQ(measurement->as<LaserScan>().step_rad, 0.008726646259971648);
  EXPECT_THAT(construction_error<ConfigError>(entry(scan + "{ start_deg: 1, start_rad: 1, step_deg: 1 }")),
              HasSubstr("not both"));
  EXPECT_THAT(construction_error<ConfigError>(entry(scan + "{ start_rad: 1, step_rad: 0 }")), HasSubstr("step_rad: 0"));
  EXPECT_THAT(construction_error<ConfigError>(entry(scan + "{ start_rad: 1, step_rad: 90 }")), HasSubstr("step_rad"));
}

TEST_F(CsvPayloads, TheBeamsOfAScanGoAroundOnceAtMost) {
  std::string row = "0";
  for (int i = 0; i < 361; ++i) row += ",1";
  write("a.csv", row + "\n");
  const auto scan = [](int beams, const std::string& step) {
    return "files: [{ path: a.csv, sensor: lidar, time: 0, payload: LaserScan, columns: { ranges_m: { first: 1, "
           "count: " +
           std::to_string(beams) + " } }, scan: { start_deg: -90, " + step + " } }]";
  };
  EXPECT_THAT(construction_error<ConfigError>(scan(181, "step_deg: 100")),
              HasSubstr("scan.step_deg: 181 beams of 100 deg cover 18000 deg; at most 360 are possible"));
  EXPECT_THAT(construction_error<ConfigError>(scan(181, "step_rad: -0.5")),
              HasSubstr("scan.step_rad: 181 beams of 28.6479 deg cover 5156.62 deg; at most 360 are possible"));
  for (const char* step : {"step_deg: 1", "step_deg: -1", "step_rad: 0.0175"})
    EXPECT_EQ(make(scan(361, step))->next()->as<LaserScan>().ranges_m.size(), 361U) << step;
}

TEST_F(CsvPayloads, BeamsMayHaveTimesOfTheirOwn) {
  write("a.csv", "t,r0,r1\n0,1,2\n");
  const std::string scan =
      "payload: LaserScan, columns: { ranges_m: { first: r0, last: r1 } }, scan: { start_deg: 0, step_deg: 1";
  EXPECT_EQ(source(scan + " }")->next()->as<LaserScan>().beam_interval_s, 0.0);
  EXPECT_EQ(source(scan + ", beam_interval_s: 1e-4 }")->next()->as<LaserScan>().beam_interval_s, 1e-4);
  EXPECT_THAT(construction_error<ConfigError>(entry(scan + ", beam_interval_s: 2 }")), HasSubstr("beam_interval_s"));
}

TEST_F(CsvPayloads, TheReferenceMayNotKnowEverything) {
  write("a.csv", "t,h\n0,1\n");
  write("truth.csv", "t_ns,x,y,yaw\n1500000000,1,2,0.5\n2000000000,3,4,\n");
  write("survey.csv", "name,x,y,r\n#1,1,2,0.25\nelm,3,4,\n");
  const auto csv = make(
      "files: [{ path: a.csv, sensor: camera, time: t, payload: CompassHeading, columns: { heading_rad: h } }]\n"
      "reference:\n"
      "  trajectory: { path: truth.csv, empty_is_unknown: true,"
      " columns: { time: { column: t_ns, scale: 1e-9 }, x_m: x, y_m: y, yaw_rad: yaw } }\n"
      "  landmarks: { path: survey.csv, empty_is_unknown: true, comment: '',"
      " columns: { name: name, x_m: x, y_m: y, radius_m: r } }\n");
  const auto reference = csv->reference();
  ASSERT_EQ(reference->trajectory.size(), 2u);
  EXPECT_TRUE(reference->trajectory[0].has_yaw);
  EXPECT_TRUE(reference->trajectory[0].is_planar);
  EXPECT_EQ(reference->trajectory[0].stamp.time_since_epoch().count(), 1'500'000'000);
  EXPECT_FALSE(reference->trajectory[1].has_yaw);
  ASSERT_EQ(reference->landmarks.size(), 2u);
  EXPECT_EQ(reference->landmarks[0].name, "#1");
  EXPECT_EQ(reference->landmarks[0].radius_m, 0.25);
  EXPECT_EQ(reference->landmarks[1].name, "elm");
  EXPECT_TRUE(std::isnan(reference->landmarks[1].radius_m));
}

}  // namespace
}  // namespace waymark
