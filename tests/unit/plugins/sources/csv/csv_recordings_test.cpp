// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <map>

#include "unit/plugins/sources/csv/csv_fixture.hpp"

namespace waymark {
namespace {

/// Real recordings, found through the environment variable WAYMARK_DATA.
class CsvRecordings : public csv_test::CsvTest {
 protected:
  void SetUp() override {
    const char* data = std::getenv("WAYMARK_DATA");
    if (data == nullptr) GTEST_SKIP() << "WAYMARK_DATA is not set";
    data_ = data;
  }

  std::map<std::string, std::vector<Measurement>> read_by_sensor(Source& source) {
    std::map<std::string, std::vector<Measurement>> result;
    Time last = Time::min();
    while (auto measurement = source.next()) {
      EXPECT_GE(measurement->stamp, last);
      last = measurement->stamp;
      result[source.channels()[measurement->sensor].sensor].push_back(std::move(*measurement));
    }
    EXPECT_TRUE(source.bad_records().empty());
    return result;
  }

  std::string data_;
};

TEST_F(CsvRecordings, CarPark) {
  const std::string log = data_ + "/acfr_car_park/";
  const auto source = make(
      "files:\n"
      "  - {path: " +
      log +
      "odometry.csv, sensor: wheels, payload: WheelSteering, time: t_s,"
      " columns: {speed_mps: rear_wheel_speed_mps, steering_rad: steering_rad}}\n"
      "  - {path: " +
      log +
      "gps.csv, sensor: gps, payload: GnssFix, time: t_s, columns: {east_m: x_m, north_m: y_m}}\n"
      "  - {path: " +
      log +
      "laser.csv.gz, sensor: lidar, payload: LaserScan, time: t_s,"
      " columns: {ranges_m: {first: r0, last: r360}, intensities: {first: i0, last: i360}},"
      " scan: {start_deg: -90, step_deg: 0.5}}\n"
      "reference:\n"
      "  trajectory: {path: " +
      log +
      "gps.csv, columns: {time: t_s, x_m: x_m, y_m: y_m}}\n"
      "  landmarks: {path: " +
      log + "beacons.csv, columns: {name: id, x_m: x_m, y_m: y_m}}\n");
  auto all = read_by_sensor(*source);
  EXPECT_EQ(all["gps"].size(), 626u);
  EXPECT_EQ(all["wheels"].size(), 5001u);
  ASSERT_EQ(all["lidar"].size(), 586u);
  for (const Measurement& one : all["lidar"]) {
    ASSERT_EQ(one.as<LaserScan>().ranges_m.size(), 361u);
    ASSERT_EQ(one.as<LaserScan>().intensities.size(), 361u);
  }
  EXPECT_FLOAT_EQ(all["lidar"][0].as<LaserScan>().ranges_m[1], 0.85F);
  EXPECT_EQ(all["wheels"][0].stamp, Time{Duration{45'024'000'000}});
  EXPECT_EQ(all["wheels"][0].as<WheelSteering>().speed_mps, 2.0120826);
  EXPECT_EQ(source->reference()->landmarks.size(), 15u);
  EXPECT_EQ(source->reference()->trajectory.size(), 626u);
}

TEST_F(CsvRecordings, VictoriaPark) {
  const std::string log = data_ + "/victoria_park/";
  const auto source = make(
      "files:\n"
      "  - {path: " +
      log +
      "DRS.txt, sensor: wheels, payload: WheelSteering, time: 0,"
      " columns: {speed_mps: 1, steering_rad: 2}}\n"
      "  - {path: " +
      log +
      "GPS.txt, sensor: gps, payload: GnssFix, time: 0, columns: {north_m: 1, east_m: 2}}\n"
      "  - {path: " +
      log +
      "laser.txt.gz, sensor: lidar, payload: LaserScan, time: 0,"
      " columns: {ranges_m: {first: 1, count: 361}}, scan: {start_deg: -90, step_deg: 0.5}}\n"
      "  - {path: " +
      log +
      "tree_detections.txt, sensor: camera, payload: LandmarkObservations, time: 0,"
      " group_by_time: true, columns: {range_m: 1, bearing_rad: {column: 2, offset: -1.5707963267948966},"
      " radius_m: {column: 3, scale: 0.5}}}\n");
  auto all = read_by_sensor(*source);
  EXPECT_EQ(all["wheels"].size(), 61763u);
  ASSERT_EQ(all["gps"].size(), 948u);
  EXPECT_EQ(all["lidar"].size(), 7230u);
  EXPECT_EQ(all["lidar"][0].as<LaserScan>().ranges_m.size(), 361u);
  EXPECT_EQ(all["gps"][1].as<GnssFix>().p_map_antenna.y(), 0.05);
  EXPECT_EQ(all["gps"][1].as<GnssFix>().p_map_antenna.x(), -0.08);
  EXPECT_EQ(all["camera"].size(), 7230u);
  std::size_t trees = 0;
  for (const Measurement& one : all["camera"]) trees += one.as<LandmarkObservations>().landmarks.size();
  EXPECT_EQ(trees, 52974u);
}

TEST_F(CsvRecordings, VictoriaParkCleanFixesOfAll) {
  const auto source = make("files: [{path: " + data_ +
                           "/victoria_park/gps_all.csv, sensor: gps, payload: GnssFix, time: t_s, columns: {east_m: "
                           "east_m, north_m: north_m}, where: [{column: in_clean_set, equals: 1}]}]");
  auto all = read_by_sensor(*source);
  ASSERT_EQ(all["gps"].size(), 948u);
  EXPECT_EQ(all["gps"][1].as<GnssFix>().p_map_antenna.x(), -0.0817);
}

TEST_F(CsvRecordings, Utias) {
  const std::string log = data_ + "/utias_mrclam_7/";
  const auto source = make(
      "files:\n"
      "  - {path: " +
      log +
      "Robot1_Odometry.dat.gz, sensor: wheels, payload: BodyTwist, time: 0,"
      " columns: {v_x_mps: 1, w_z_radps: 2}}\n"
      "  - {path: " +
      log +
      "Robot1_Measurement.dat, sensor: camera, payload: LandmarkObservations, time: 0,"
      " group_by_time: true, columns: {identity: 1, range_m: 2, bearing_rad: 3},"
      " where: [{column: 1, not_in: [5, 14, 41, 32, 23]}]}\n"
      "reference: {trajectory: {path: " +
      log +
      "Robot1_Groundtruth.dat.gz,"
      " columns: {time: 0, x_m: 1, y_m: 2, yaw_rad: 3}}}\n");
  auto all = read_by_sensor(*source);
  EXPECT_EQ(all["wheels"].size(), 58598u);
  EXPECT_EQ(all["wheels"][0].stamp, Time{Duration{1248446188323000000}});
  EXPECT_EQ(source->reference()->trajectory.size(), 58389u);
  std::size_t landmarks = 0;
  std::size_t in_groups = 0;
  for (const Measurement& one : all["camera"]) {
    const auto& set = one.as<LandmarkObservations>().landmarks;
    landmarks += set.size();
    if (set.size() > 1) ++in_groups;
  }
  EXPECT_EQ(landmarks, 2578u);
  EXPECT_GT(in_groups, 0u);
}

}  // namespace
}  // namespace waymark
