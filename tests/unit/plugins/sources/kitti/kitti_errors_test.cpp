// SPDX-License-Identifier: Apache-2.0
// needs plugins: csv
// What the kitti source does with a recording that is incomplete or damaged, and with a YAML that is wrong.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "unit/plugins/sources/csv/csv_fixture.hpp"
#include "unit/plugins/sources/kitti/kitti_fixture.hpp"
#include "waymark/base/error.hpp"

namespace waymark::kitti_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

const std::vector<Point> kPoints{{10.0f, 0.0f, 0.0f, 0.5f}, {0.0f, 8.0f, 0.0f, 0.5f}};

class KittiErrorsTest : public KittiTest {
 protected:
  /// Reading stops at the bad frame by default; with one bad record allowed it goes on, and reports it.
  void expect_one_bad(const std::string& keys, const std::string& place, const std::string& reason,
                      std::size_t good) const {
    EXPECT_THAT(
        [&] { read_all(*make("height_m: [1, 2]", keys)); },
        ThrowsMessage<DataError>(AllOf(HasSubstr(place + ": "), HasSubstr(reason), HasSubstr("max_bad_records"))));
    const auto source = make("height_m: [1, 2]", "max_bad_records: 1\n" + keys);
    EXPECT_EQ(read_all(*source).size(), good);
    ASSERT_EQ(source->bad_records().size(), 1U);
    EXPECT_THAT(source->bad_records()[0].place, HasSubstr(place));
    EXPECT_THAT(source->bad_records()[0].reason, HasSubstr(reason));
  }
  void expect_refused(const std::string& lidar_keys, const std::string& more, const std::string& words) const {
    EXPECT_THAT([&] { make(lidar_keys, more); },
                ThrowsMessage<ConfigError>(AllOf(HasSubstr("run.yaml:"), HasSubstr(words))));
  }
  const std::string kCamera = "calibration: none\ncamera: { sensor: camera }\n";
};

TEST_F(KittiErrorsTest, ACalibrationNeedsACamera) {
  write_cloud(0, kPoints);
  EXPECT_EQ(read_all(*make("height_m: [1, 2]", "calibration: none")).size(), 1U);
  EXPECT_EQ(read_all(*make("height_m: [1, 2]", "calibration: auto")).size(), 1U);
  expect_refused("height_m: [1, 2]", "calibration: calib", "is for the camera, and there is no `camera`");
}

TEST_F(KittiErrorsTest, ATruncatedCloudIsABadRecord) {
  write_cloud(0, kPoints);
  write(cloud_file(1), bytes_of(kPoints).substr(0, 30));
  write_cloud(2, kPoints);
  expect_one_bad("", cloud_file(1), "30 bytes are not a whole number of points of 16 bytes", 2);
}

TEST_F(KittiErrorsTest, AnEmptyCloudIsABadRecord) {
  write_cloud(0, kPoints);
  write(cloud_file(1), "");
  expect_one_bad("", cloud_file(1), "is empty", 1);
}

TEST_F(KittiErrorsTest, AFileThatIsFarTooLongIsABadRecord) {
  write_cloud(0, kPoints);
  write(cloud_file(1), "");
  std::filesystem::resize_file(folder_ / "log" / cloud_file(1),
                               std::uintmax_t{257} << 20);  // takes no room on the disk
  expect_one_bad("", cloud_file(1), "is larger than 256 MiB", 1);
}

TEST_F(KittiErrorsTest, AGzipFileThatEndsEarlyOrIsDamagedIsABadRecord) {
  const std::string whole = csv_test::gzip(bytes_of(std::vector<Point>(50, kPoints[0])));
  const std::string file = "velodyne_points/data/0000000001.bin.gz";
  write_cloud(0, kPoints);
  write(file, whole.substr(0, whole.size() / 2));
  expect_one_bad("", file, "the gzip stream ends early", 1);
  std::string damaged = whole;
  damaged[whole.size() / 2] ^= 0x10;
  write(file, damaged);
  expect_one_bad("", file, "the gzip stream is damaged", 1);
}

TEST_F(KittiErrorsTest, PointsThatAreNotFiniteAreLeftOutAndTold) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  write_cloud(0, {{nan, 0.0f, 0.0f, 0.5f}, kPoints[0], {5.0f, 0.0f, 0.0f, inf}});
  expect_one_bad("", cloud_file(0), "2 of 3 points are not finite", 1);
  const auto source = make("height_m: [1, 2], step_deg: 90, range_max_m: 50", "max_bad_records: 1");
  EXPECT_THAT(ranges_of(*source), ::testing::ElementsAre(51.0f, 51.0f, 10.0f, 51.0f));
}

TEST_F(KittiErrorsTest, AMissingImageOrCloudIsABadRecord) {
  for (int frame = 0; frame < 3; ++frame) {
    write_cloud(frame, kPoints);
    write_image(frame, "picture");
  }
  std::filesystem::remove(folder_ / "log" / image_file(1));
  expect_one_bad(kCamera, image_file(1), "is missing", 5);
  write_image(1, "picture");
  std::filesystem::remove(folder_ / "log" / cloud_file(2));
  expect_one_bad(kCamera, cloud_file(2), "is missing", 5);
}

TEST_F(KittiErrorsTest, AnEmptyImageIsABadRecord) {
  write_cloud(0, kPoints);
  write_image(0, "");
  expect_one_bad(kCamera, image_file(0), "is empty", 1);
}

TEST_F(KittiErrorsTest, AFrameWithoutALaterStampIsABadRecord) {
  for (int frame = 0; frame < 3; ++frame) write_cloud(frame, kPoints);
  write("velodyne_points/timestamps.txt", "2011-09-26 13:02:25.1\n2011-09-26 13:02:25.2\n");
  expect_one_bad("", cloud_file(2), "has no stamp", 2);
  write("velodyne_points/timestamps.txt", "2011-09-26 13:02:25.1\n2011-09-26 13:02:25.1\n2011-09-26 13:02:25.3\n");
  expect_one_bad("", cloud_file(1), "not later than the one before", 2);
}

TEST_F(KittiErrorsTest, AStampThatIsNoneIsNamedWithItsLine) {
  write_cloud(0, kPoints);
  for (const char* stamp : {"2011-09-26 13:02:61.1", "2011-02-30 13:02:25.1", "13:02:25.1", "2011-09-26 1a:02:25.1", "",
                            "2300-09-26 13:02:25.1", "9999-09-26 13:02:25.1", "0001-01-01 00:00:00.0"}) {
    write("velodyne_points/timestamps.txt",
          "2011-09-26 13:02:25.1\n" + std::string(stamp) + "\n2011-09-26 13:02:25.3\n");
    expect_refused("height_m: [1, 2]", "", "timestamps.txt:2: \"" + std::string(stamp) + "\"");
  }
}

TEST_F(KittiErrorsTest, AFrameNumberThatIsADateHasNoStamp) {
  write_cloud(0, kPoints);
  write("velodyne_points/data/20110926130225951.bin", "0123456789abcdef");
  expect_one_bad("", "velodyne_points/data/20110926130225951.bin", "more than 146 years", 1);
}

TEST_F(KittiErrorsTest, WhatIsNoRecordingIsRefused) {
  expect_refused("height_m: [1, 2]", "", "log is not a folder");
  std::filesystem::create_directories(folder_ / "log");
  expect_refused("height_m: [1, 2]", "", "velodyne_points/data: no such folder");
  write("velodyne_points/data/readme.txt", "nothing");
  expect_refused("height_m: [1, 2]", "", "holds no file <number>.bin or <number>.bin.gz");
  write_cloud(0, kPoints);
  expect_refused("height_m: [1, 2]", kCamera, "image_02/data: no such folder");
}

TEST_F(KittiErrorsTest, WrongKeysAreRefused) {
  write_cloud(0, kPoints);
  expect_refused("height_m: [2, 1]", "", "lidar.height_m: the lower bound first");
  expect_refused("height_m: [1, 2], step_deg: 1, beams: 361", "", "more than a turn");
  expect_refused("height_m: [1, 2], range_min_m: 9, range_max_m: 5", "", "must be < range_max_m");
  expect_refused("height_m: [1, 2], step: 1", "", "unknown key");
  write_image(0, "picture");
  expect_refused("height_m: [1, 2]", "calibration: none\ncamera: { sensor: lidar }", "takes waymark/LaserScan@1");
  expect_refused("height_m: [1, 2]", "calibration: none\ncamera: { sensor: eye }", "there is no sensor \"eye\"");
  write("image_02/timestamps.txt", "2011-09-26 13:02:25.1\n");
  expect_refused("height_m: [1, 2]", "calibration: none\ncamera: { sensor: camera, stamp: own }", "in both folders");
}

}  // namespace
}  // namespace waymark::kitti_test
