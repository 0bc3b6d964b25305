// SPDX-License-Identifier: Apache-2.0
// needs plugins: csv
// What the kitti source delivers: planar cuts, stamps, images, and its calibration check. Bad data:
// kitti_errors_test.cpp.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "unit/plugins/sources/csv/csv_fixture.hpp"
#include "unit/plugins/sources/kitti/kitti_fixture.hpp"
#include "waymark/base/error.hpp"

namespace waymark::kitti_test {
namespace {

using ::testing::ElementsAre;
using ::testing::FloatEq;
using ::testing::FloatNear;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr float kFree = 51.0f;
const std::string kQuarters = "height_m: [1, 2], step_deg: 90, range_min_m: 2, range_max_m: 50";

Point at(double range, double bearing_deg, double z = 0.0) {
  const double bearing = bearing_deg * std::numbers::pi / 180.0;
  return {static_cast<float>(range * std::cos(bearing)), static_cast<float>(range * std::sin(bearing)),
          static_cast<float>(z), 0.5f};
}

TEST_F(KittiTest, EachBeamIsTheNearestPointOfItsBinBetweenTheHeights) {
  write_cloud(0, {{5.0f, 0.0f, 0.0f, 0.1f},     // ahead, 1.5 m above the base
                  {4.0f, 3.0f, 0.2f, 0.6f},     // 5 m, but the horizontal range counts: as far
                  {4.0f, 0.3f, 0.4f, 0.7f},     // the nearest one: sqrt(16.09)
                  {3.0f, 0.0f, 0.6f, 0.9f},     // 2.1 m up
                  {3.0f, 0.0f, -0.6f, 0.9f},    // 0.9 m up
                  {0.0f, 6.0f, 0.0f, 0.3f},     // to the left
                  {0.0f, -1.9f, 0.0f, 0.9f},    // to the right, nearer than range_min_m
                  {0.0f, -50.1f, 0.0f, 0.9f},   // farther than range_max_m
                  {-7.0f, -0.1f, 0.0f, 0.4f},   // behind, on both sides of the seam
                  {-6.0f, 0.1f, 0.0f, 0.2f}});  // sqrt(36.01)
  const auto source = make(kQuarters);
  const auto measurement = source->next();
  ASSERT_TRUE(measurement);
  const auto& scan = measurement->as<LaserScan>();
  EXPECT_DOUBLE_EQ(scan.start_rad, -std::numbers::pi);
  EXPECT_DOUBLE_EQ(scan.step_rad, std::numbers::pi / 2.0);
  EXPECT_THAT(scan.ranges_m, ElementsAre(FloatEq(std::sqrt(36.01f)), kFree, FloatEq(std::sqrt(16.09f)), 6.0f));
  EXPECT_THAT(scan.intensities, ElementsAre(0.2f, 0.0f, 0.7f, 0.3f));
}

TEST_F(KittiTest, ABinReachesHalfAStepToBothSidesOfItsBeam) {
  write_cloud(0, {at(11.0, -5.1), at(12.0, -4.9), at(13.0, 4.9), at(14.0, 5.1), at(15.0, 24.9), at(16.0, 25.1)});
  const auto source = make("height_m: [1, 2], start_deg: 0, step_deg: 10, beams: 3, range_max_m: 50");
  EXPECT_THAT(ranges_of(*source),
              ElementsAre(FloatNear(12.0f, 1e-5f), FloatNear(14.0f, 1e-5f), FloatNear(15.0f, 1e-5f)));
}

TEST_F(KittiTest, ATiltedScannerIsLevelledAndKeepsItsHeading) {
  // 10° nose down, 2.5 m up, turned to the left: ten metres along its axis lies 1.736 m lower and 9.848 m away.
  lidar_.T_base_sensor = Pose{so3::from_rpy(0.0, std::numbers::pi / 18.0, 1.0), {1.0, 2.0, 2.5}};
  write_cloud(0, {{10.0f, 0.0f, 0.0f, 0.5f}});
  EXPECT_THAT(ranges_of(*make("height_m: [0.76, 0.77], step_deg: 90, range_max_m: 50")),
              ElementsAre(kFree, kFree, FloatNear(9.848078f, 1e-5f), kFree));
  EXPECT_THAT(ranges_of(*make("height_m: [0.77, 3], step_deg: 90, range_max_m: 50")),
              ElementsAre(kFree, kFree, kFree, kFree));
}

TEST_F(KittiTest, GzipAndPlainFilesGiveTheSame) {
  const std::vector<Point> points{at(11.0, 1.0), at(12.0, 90.0)};
  write_cloud(0, points);
  write("velodyne_points/data/0000000001.bin.gz", csv_test::gzip(bytes_of(points)));
  // A plain file whose first bytes look like gzip.
  std::string disguised = bytes_of(points);
  disguised[0] = '\x1f';
  disguised[1] = '\x8b';
  write(cloud_file(2), disguised);
  const auto source = make(kQuarters);
  const auto expected = ranges_of(*source);
  EXPECT_THAT(expected, ElementsAre(kFree, kFree, FloatNear(11.0f, 1e-5f), FloatNear(12.0f, 1e-5f)));
  EXPECT_EQ(ranges_of(*source), expected);
  EXPECT_THAT(ranges_of(*source), ElementsAre(kFree, kFree, FloatNear(11.0f, 0.05f), FloatNear(12.0f, 1e-5f)));
}

TEST_F(KittiTest, ACloudMayBeDeliveredWholeOrThinnedOut) {
  lidar_.payload = "waymark/PointCloud@1";
  const float nan = std::numeric_limits<float>::quiet_NaN();
  write_cloud(
      0, {{5.0f, 1.0f, -1.5f, 0.1f}, {4.0f, 3.0f, 0.2f, 0.6f}, {4.0f, nan, 0.4f, 0.7f}, {0.0f, 0.0f, 90.0f, 1.0f}});
  const auto source = make("payload: PointCloud", "max_bad_records: 1");
  EXPECT_EQ(source->channels().at(0).payload_type, "waymark/PointCloud@1");
  const auto measurement = source->next();
  ASSERT_TRUE(measurement);
  const auto& cloud = measurement->as<PointCloud>();
  EXPECT_THAT(cloud.points_m, ElementsAre(Eigen::Vector3f(5.0f, 1.0f, -1.5f), Eigen::Vector3f(4.0f, 3.0f, 0.2f),
                                          Eigen::Vector3f(0.0f, 0.0f, 90.0f)));
  EXPECT_THAT(cloud.intensities, ElementsAre(0.1f, 0.6f, 1.0f));
  EXPECT_THAT(cloud.offsets_s, ::testing::IsEmpty());
  EXPECT_THAT(source->bad_records().at(0).reason, HasSubstr("1 of 4 points are not finite"));
  EXPECT_EQ(make("payload: PointCloud, every_nth_point: 3")->next()->as<PointCloud>().points_m.size(), 2U);
  // The keys of the cut are none of a cloud, and the sensor must take clouds.
  EXPECT_THAT([&] { make("payload: PointCloud, height_m: [1, 2]"); },
              ThrowsMessage<ConfigError>(HasSubstr("height_m")));
  EXPECT_THAT([&] { make(); }, ThrowsMessage<ConfigError>(HasSubstr("takes waymark/PointCloud@1, but this gives")));
}

TEST_F(KittiTest, WithoutStampsFramesAreAPeriodApart) {
  for (const int frame : {7, 3}) write_cloud(frame, {at(10.0, 0.0)});
  const auto source = make("height_m: [1, 2]", "frame_period_s: 0.05");
  const auto all = read_all(*source);
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].stamp, parse_time("0.15"));
  EXPECT_EQ(all[1].stamp, parse_time("0.35"));
  EXPECT_EQ(all[1].arrival, all[1].stamp);
  EXPECT_EQ(all[1].sequence, 1U);
}

TEST_F(KittiTest, StampsAreReadToTheNanosecond) {
  write_cloud(0, {at(10.0, 0.0)});
  write_cloud(1, {at(10.0, 0.0)});
  write("velodyne_points/timestamps.txt", "2011-09-26 13:02:25.951199337\n2011-09-26 13:02:26.054903622\r\n");
  const auto all = read_all(*make());
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].stamp, parse_time("1317042145.951199337"));
  EXPECT_EQ(all[1].stamp, parse_time("1317042146.054903622"));
}

TEST_F(KittiTest, AnImageComesBeforeItsScanWithItsStamp) {
  for (int frame = 0; frame < 2; ++frame) {
    write_cloud(frame, {at(10.0, 0.0)});
    write_image(frame, "picture " + std::to_string(frame));
  }
  write("velodyne_points/timestamps.txt", "2011-09-26 13:02:25.0\n2011-09-26 13:02:25.1\n");
  write("image_02/timestamps.txt", "2011-09-26 13:02:25.02\n2011-09-26 13:02:25.12\n");
  const auto source = make_with_camera();
  ASSERT_EQ(source->channels().size(), 2U);
  EXPECT_EQ(source->channels()[0].sensor, "camera");
  EXPECT_EQ(source->channels()[1].sensor, "lidar");
  const auto all = read_all(*source);
  ASSERT_EQ(all.size(), 4U);
  for (std::size_t frame = 0; frame < 2; ++frame) {
    EXPECT_EQ(all[2 * frame].sensor, 0U);
    EXPECT_EQ(all[2 * frame].stamp, all[2 * frame + 1].stamp);
    const auto& image = all[2 * frame].as<Image>();
    EXPECT_EQ(image.encoding, Image::Encoding::compressed);
    EXPECT_EQ(std::string(image.data.begin(), image.data.end()), "picture " + std::to_string(frame));
  }
  EXPECT_EQ(source->progress(), 1.0);
}

TEST_F(KittiTest, WithItsOwnStampAnImageComesWhenItWasTaken) {
  for (int frame = 0; frame < 2; ++frame) {
    write_cloud(frame, {at(10.0, 0.0)});
    write_image(frame, "picture");
  }
  write("velodyne_points/timestamps.txt", "2011-09-26 13:02:25.0\n2011-09-26 13:02:25.1\n");
  write("image_02/timestamps.txt", "2011-09-26 13:02:25.02\n2011-09-26 13:02:25.12\n");
  const auto source = make("height_m: [1, 2]", "calibration: none\ncamera: { sensor: camera, stamp: own }");
  std::vector<std::uint32_t> order;
  std::vector<Time> stamps;
  for (const Measurement& m : read_all(*source)) {
    order.push_back(m.sensor);
    stamps.push_back(m.stamp);
  }
  EXPECT_THAT(order, ElementsAre(1, 0, 1, 0));
  EXPECT_EQ(stamps.at(1) - stamps.at(0), std::chrono::milliseconds(20));
  EXPECT_TRUE(std::ranges::is_sorted(stamps));
}

/// A recording of one frame with its calibration.
class KittiCalibrationTest : public KittiTest {
 protected:
  KittiCalibrationTest() {
    write_cloud(0, {at(10.0, 0.0)});
    write_image(0, "picture");
    write_calibration();
    // The scanner is at (1, 0, 1.5), the camera 0.3 m before, 0.2 m to the left of and 0.2 m below it.
    camera_.T_base_sensor = Pose{so3::from_rpy(0.0, 0.0, 0.0), {1.3, 0.2, 1.3}};
    camera_.intrinsics = Intrinsics{640, 480, 700.0, 700.0, 320.0, 240.0, {}};
  }
  void expect_refused(const std::string& words) const {
    EXPECT_THAT([&] { make_with_camera(""); }, ThrowsMessage<ConfigError>(HasSubstr(words)));
  }
};

TEST_F(KittiCalibrationTest, ACameraThatFitsIsTaken) { EXPECT_EQ(read_all(*make_with_camera("")).size(), 2U); }

TEST_F(KittiCalibrationTest, TheCalibrationMayLieInTheFolderOfTheDay) {
  std::filesystem::rename(folder_ / "log/calib/calib_velo_to_cam.txt", folder_ / "calib_velo_to_cam.txt");
  std::filesystem::rename(folder_ / "log/calib/calib_cam_to_cam.txt", folder_ / "calib_cam_to_cam.txt");
  EXPECT_EQ(read_all(*make_with_camera("")).size(), 2U);
  camera_.intrinsics->fx = 710.0;
  expect_refused("another focal length");
}

TEST_F(KittiCalibrationTest, ACameraElsewhereIsRefusedWithTheRightLines) {
  camera_.T_base_sensor->p.x() += 0.01;
  expect_refused("run.yaml:");
  expect_refused(
      "sensors.camera does not fit the calibration of the recording: its base_T_sensor is 0.010 m and 0.00 deg off; "
      "right are base_T_sensor: { xyz_m: [1.3000, 0.2000, 1.3000], roll_deg: 0, pitch_deg: 0, yaw_deg: 0 }, "
      "intrinsics: { size_px: [640, 480], focal_px: [700.0000, 700.0000], center_px: [320.0000, 240.0000] }");
}

TEST_F(KittiCalibrationTest, TheRightLinesFollowTheScannersPlace) {
  // Turned by 90° to the left: the camera is 0.3 m to the left of the scanner, 0.2 m behind it, and looks to the left.
  lidar_.T_base_sensor = Pose{so3::from_rpy(0.0, 0.0, std::numbers::pi / 2.0), {0.0, 0.0, 2.0}};
  expect_refused("xyz_m: [-0.2000, 0.3000, 1.8000], roll_deg: 0, pitch_deg: 0, yaw_deg: 90.0000");
}

TEST_F(KittiCalibrationTest, EveryDifferenceIsNamed) {
  const Mounting good = camera_;
  camera_.T_base_sensor->q = so3::from_rpy(0.0, 0.0, 0.002);
  expect_refused("its base_T_sensor is 0.000 m and 0.11 deg off");
  camera_.intrinsics.reset();
  expect_refused("0.11 deg off and no intrinsics");
  camera_ = good;
  camera_.T_base_sensor.reset();
  expect_refused("it has no base_T_sensor");
  camera_ = good;
  camera_.intrinsics->cy = 240.2;
  expect_refused("its intrinsics have another centre");
  camera_ = good;
  camera_.intrinsics->width = 1242;
  expect_refused("its intrinsics have another size");
  camera_ = good;
  camera_.intrinsics->distortion[0] = -0.3;
  expect_refused("the images are rectified");
}

TEST_F(KittiCalibrationTest, CanBeLeftOut) {
  camera_.T_base_sensor.reset();
  camera_.intrinsics.reset();
  EXPECT_EQ(read_all(*make_with_camera("calibration: none")).size(), 2U);
}

TEST_F(KittiCalibrationTest, AFileThatIsNoneIsNamed) {
  write("calib/calib_cam_to_cam.txt", "P_rect_02: 1 2 3\n");
  expect_refused("calib_cam_to_cam.txt: a line \"P_rect_02:\" with 12 numbers is expected");
  std::filesystem::remove(folder_ / "log/calib/calib_cam_to_cam.txt");
  expect_refused("calib_cam_to_cam.txt: cannot be read");
  std::filesystem::remove_all(folder_ / "log/calib");
  expect_refused("calibration: there is no calib_velo_to_cam.txt");
}

}  // namespace
}  // namespace waymark::kitti_test
