// SPDX-License-Identifier: Apache-2.0
// How the source rosbag1 reads messages, their order and their times.
#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "rosbag1_fixture.hpp"
#include "unit/plugins/shared/cdr/timed_cloud.hpp"

namespace waymark {
namespace {

using namespace rosbag1_test;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::int64_t kSecond = 1'000'000'000;

class Rosbag1 : public Rosbag1Test {
 protected:
  static std::vector<double> speeds(Source& source) {
    std::vector<double> all;
    for (const Measurement& m : read_all(source)) all.push_back(m.as<BodyTwist>().v_x_mps);
    return all;
  }
};

TEST_F(Rosbag1, ReadsAnImu) {
  const auto all = one(kImu, imu_message(4 * kSecond + 1, {.q = {0.0, 0.6, 0.0, 0.8}}));
  ASSERT_THAT(all, SizeIs(1));
  EXPECT_EQ(all[0].stamp.time_since_epoch().count(), 4'000'000'001);
  EXPECT_EQ(all[0].arrival.time_since_epoch().count(), 5'000'000'000);
  const auto& sample = all[0].as<ImuSample>();
  EXPECT_EQ(sample.w_sensor, Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(sample.f_sensor, Eigen::Vector3d(0.0, 0.0, 9.81));
  EXPECT_TRUE(sample.m_sensor.array().isNaN().all());
  EXPECT_EQ(sample.q_enu_sensor.coeffs(), Eigen::Vector4d(0.0, 0.6, 0.0, 0.8));
}

TEST_F(Rosbag1, WhatAnImuDoesNotMeasureIsUnknown) {
  const auto no_orientation = one(kImu, imu_message(1, {.q_variance = -1.0}));
  EXPECT_TRUE(no_orientation.at(0).as<ImuSample>().q_enu_sensor.coeffs().array().isNaN().all());
  const auto zero_quaternion = one(kImu, imu_message(1, {.q = {0.0, 0.0, 0.0, 0.0}}));
  EXPECT_TRUE(zero_quaternion.at(0).as<ImuSample>().q_enu_sensor.coeffs().array().isNaN().all());
  const auto no_rate = one(kImu, imu_message(1, {.w_variance = -1.0}));
  EXPECT_TRUE(no_rate.at(0).as<ImuSample>().w_sensor.array().isNaN().all());
  const auto no_force = one(kImu, imu_message(1, {.f = {kNaN, 0.0, 0.0}, .f_variance = -1.0}));
  EXPECT_TRUE(no_force.at(0).as<ImuSample>().f_sensor.array().isNaN().all());
  EXPECT_THAT(bad_, IsEmpty());
}

TEST_F(Rosbag1, AnOrientationIsNormalisedOrRefused) {
  const auto rounded = one(kImu, imu_message(1, {.q = {0.0, 0.0, 0.7071, 0.7071}}));
  EXPECT_NEAR(rounded.at(0).as<ImuSample>().q_enu_sensor.norm(), 1.0, 1e-15);
  EXPECT_THAT(one(kImu, imu_message(1, {.q = {0.0, 0.0, 0.0, 0.5}})), IsEmpty());
  EXPECT_THAT(bad_, HasSubstr("/x: the orientation (0, 0, 0, 0.5) is not a unit quaternion"));
}

TEST_F(Rosbag1, ReadsAFix) {
  const auto all = one(kFix, fix_message(1, 0, 49.5));
  const auto& fix = all.at(0).as<GnssFix>();
  EXPECT_EQ(fix.type, GnssFix::Type::single);
  EXPECT_EQ(fix.latitude_deg, 49.5);
  EXPECT_EQ(fix.longitude_deg, 8.5);
  EXPECT_EQ(fix.height_m, 112.0);
  EXPECT_EQ(fix.sigma_horizontal_m, 1.0);
  EXPECT_EQ(fix.sigma_vertical_m, 2.0);
  EXPECT_EQ(one(kFix, fix_message(1, 1, 49.5)).at(0).as<GnssFix>().type, GnssFix::Type::differential);
  EXPECT_EQ(one(kFix, fix_message(1, 2, 49.5)).at(0).as<GnssFix>().type, GnssFix::Type::differential);
  EXPECT_TRUE(std::isnan(one(kFix, fix_message(1, 0, 49.5, 0)).at(0).as<GnssFix>().sigma_horizontal_m));
}

TEST_F(Rosbag1, NoFixIsAMeasurementAsIsAFixWithoutAPosition) {
  const auto none = one(kFix, fix_message(1, -1, kNaN));
  EXPECT_EQ(none.at(0).as<GnssFix>().type, GnssFix::Type::none);
  EXPECT_TRUE(std::isnan(none.at(0).as<GnssFix>().latitude_deg));
  const auto of_a_careless_driver = one(kFix, fix_message(1, 0, kNaN));
  EXPECT_EQ(of_a_careless_driver.at(0).as<GnssFix>().type, GnssFix::Type::none);
  EXPECT_EQ(bad_, "");
  EXPECT_THAT(one(kFix, fix_message(1, 0, 95.0)), IsEmpty());
  EXPECT_THAT(bad_, HasSubstr("95 is not a latitude"));
}

TEST_F(Rosbag1, OneTopicFeedsSeveralSensors) {
  BagWriter bag;
  bag.add(bag.connect("/odom", kOdometry), 10, odometry_message(9, 1.5, 0.7));
  bag.end_chunk();
  write_bag(bag);
  const auto source = make("{ topic: /odom, sensor: a }, { topic: /odom, sensor: b, payload: Height }");
  EXPECT_THAT(source->channels(), SizeIs(2));
  const auto all = read_all(*source);
  ASSERT_THAT(all, SizeIs(2));
  EXPECT_EQ(all[0].as<BodyTwist>().v_x_mps, 0.7);
  EXPECT_EQ(all[0].as<BodyTwist>().v_y_mps, 0.2);
  EXPECT_EQ(all[0].as<BodyTwist>().w_z_radps, -0.3);
  EXPECT_EQ(all[1].as<Height>().height_m, 1.5);
  EXPECT_EQ(all[1].as<Height>().sigma_m, 0.2);
  EXPECT_EQ(all[1].stamp.time_since_epoch().count(), 9);
}

TEST_F(Rosbag1, ReadsTwistsAndFields) {
  EXPECT_EQ(one(kTwist, twist_message(1, 1.25)).at(0).as<BodyTwist>().v_x_mps, 1.25);
  EXPECT_THAT(bad_, IsEmpty());
  EXPECT_EQ(one(kTwistWithCovariance, twist_message(1, 1.25) + covariance(36, 1)).at(0).as<BodyTwist>().w_z_radps, 0.5);
  const auto field = one(kField, header(1) + packed({1e-6, 2e-6, -4e-5}) + covariance(9, 0));
  EXPECT_THAT(bad_, IsEmpty());
  EXPECT_EQ(field.at(0).as<MagneticField>().m_sensor, Eigen::Vector3d(1e-6, 2e-6, -4e-5));
}

TEST_F(Rosbag1, ReadsAScan) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const auto scan = [](std::initializer_list<float> ranges, std::initializer_list<float> intensities) {
    const auto list = [](std::initializer_list<float> v) {
      return bytes_of(static_cast<std::uint32_t>(v.size())) + packed(v);
    };
    return header(1) + packed({-1.5f, 1.5f, 0.5f, 0.25f, 0.1f, 0.2f, 30.0f}) + list(ranges) + list(intensities);
  };
  const auto all =
      one(kScan, scan({1.0f, kInfinity, -kInfinity, static_cast<float>(kNaN), 40.0f}, {1.0f, 2.0f, 3.0f, 4.0f, 5.0f}));
  const auto& got = all.at(0).as<LaserScan>();
  EXPECT_EQ(got.start_rad, -1.5);
  EXPECT_EQ(got.step_rad, 0.5);
  EXPECT_EQ(got.beam_interval_s, 0.25);
  EXPECT_THAT(got.ranges_m, ElementsAre(1.0f, kInfinity, 0.0f, kInfinity, 40.0f));
  EXPECT_THAT(got.intensities, SizeIs(5));
  EXPECT_THAT(one(kScan, scan({1.0f, 2.0f}, {1.0f})), IsEmpty());
  EXPECT_THAT(bad_, HasSubstr("2 ranges, but 1 intensities"));
}

/// As ROS 1 serializes it.
std::string serialized(const ros::sensor_msgs::PointCloud2& cloud, std::int64_t stamp) {
  std::string out = header(stamp) + packed({cloud.height, cloud.width});
  out += bytes_of(static_cast<std::uint32_t>(cloud.fields.size()));
  for (const auto& field : cloud.fields)
    out += counted(field.name) + bytes_of(field.offset) + bytes_of(field.datatype) + bytes_of(field.count);
  out += bytes_of(static_cast<std::uint8_t>(cloud.is_bigendian)) + packed({cloud.point_step, cloud.row_step});
  out += counted({reinterpret_cast<const char*>(cloud.data.data()), cloud.data.size()});
  return out + bytes_of(static_cast<std::uint8_t>(cloud.is_dense));
}

TEST_F(Rosbag1, ReadsACloudWithTheTimesOfItsPoints) {
  const auto cloud = ros_test::timed_cloud({}, "offset_time", ros_test::kUint32, {0, 5e8});
  const auto all = one(kCloud, serialized(cloud, 4 * kSecond));
  ASSERT_THAT(all, SizeIs(1));
  const auto& got = all[0].as<PointCloud>();
  EXPECT_THAT(got.points_m, ElementsAre(Eigen::Vector3f(0.0f, 0.0f, 0.0f), Eigen::Vector3f(1.0f, 2.0f, 3.0f)));
  EXPECT_THAT(got.intensities, ElementsAre(0.0f, 10.0f));
  EXPECT_THAT(got.offsets_s, ElementsAre(0.0f, 0.5f));
}

TEST_F(Rosbag1, ACloudWithSizesThatDoNotFitIsSkipped) {
  auto cloud = ros_test::timed_cloud({}, "t", ros_test::kUint32, {0, 1e8});
  cloud.height = 0xffff'ffff;
  EXPECT_THAT(one(kCloud, serialized(cloud, kSecond)), IsEmpty());
  EXPECT_THAT(bad_, HasSubstr("a cloud of 2 x 4294967295 points of 20 bytes in rows of 40 has 40 bytes"));
  // More bytes than the message has.
  std::string cut = serialized(ros_test::timed_cloud({}, "t", ros_test::kUint32, {0, 1e8}), kSecond);
  cut.resize(cut.size() - 2);
  EXPECT_THAT(one(kCloud, cut), IsEmpty());
}

TEST_F(Rosbag1, ReadsImages) {
  const auto image = [](std::uint32_t width, const std::string& encoding, std::uint32_t step, const std::string& data) {
    return header(1) + packed({2U, width}) + counted(encoding) + bytes_of(std::uint8_t{0}) + bytes_of(step) +
           counted(data);
  };
  const auto rgb = one(kImage, image(1, "rgb8", 4, "rgb.RGB."));
  EXPECT_EQ(rgb.at(0).as<Image>().encoding, Image::Encoding::bgr8);
  EXPECT_THAT(rgb.at(0).as<Image>().data, ElementsAre('b', 'g', 'r', 'B', 'G', 'R'));
  EXPECT_THAT(one(kImage, image(1, "bgra8", 4, "bgraBGRA")).at(0).as<Image>().data,
              ElementsAre('b', 'g', 'r', 'B', 'G', 'R'));
  const auto mono = one(kImage, image(2, "mono8", 3, "ab.cd."));
  EXPECT_EQ(mono.at(0).as<Image>().encoding, Image::Encoding::mono8);
  EXPECT_THAT(mono.at(0).as<Image>().data, ElementsAre('a', 'b', 'c', 'd'));
  EXPECT_THAT(one(kImage, image(2, "bayer_rggb8", 2, "abcd")), IsEmpty());
  EXPECT_THAT(bad_, HasSubstr("\"bayer_rggb8\""));
  EXPECT_THAT(one(kImage, image(2, "mono8", 2, "abc")), IsEmpty());
  EXPECT_THAT(bad_, HasSubstr("2 x 2 pixels in rows of 2 bytes has 3 bytes"));
  const auto file = one(kCompressed, header(1) + counted("jpeg") + counted("\xff\xd8"));
  EXPECT_EQ(file.at(0).as<Image>().encoding, Image::Encoding::compressed);
  EXPECT_THAT(file.at(0).as<Image>().data, ElementsAre(0xff, 0xd8));
}

TEST_F(Rosbag1, EveryCompressionGivesTheSame) {
  for (const std::string compression : {"none", "bz2", "lz4"}) {
    BagWriter bag;
    const auto connection = bag.connect("/x", kTwist);
    for (int k = 1; k <= 300; ++k) {
      bag.add(connection, k, twist_message(k, 0.1 * k));
      if (k % 100 == 0) bag.end_chunk(compression);
    }
    write_bag(bag);
    const auto source = make("{ topic: /x, sensor: a }");
    const std::vector<double> got = speeds(*source);
    ASSERT_THAT(got, SizeIs(300)) << compression;
    for (int k = 1; k <= 300; ++k) EXPECT_EQ(got[static_cast<std::size_t>(k - 1)], 0.1 * k);
    EXPECT_EQ(source->progress(), 1.0);
    EXPECT_THAT(source->bad_records(), IsEmpty());
  }
}

TEST_F(Rosbag1, MergesChunksAndBagsByTheTimeOfRecording) {
  BagWriter first;
  const auto x = first.connect("/x", kTwist);
  first.add(x, 30, twist_message(1, 3));
  first.add(x, 10, twist_message(1, 1));
  first.end_chunk();
  const auto other = first.connect("/x", kTwist);  // a second publisher
  first.add(other, 20, twist_message(1, 2));
  first.add(other, 50, twist_message(1, 5));
  first.end_chunk("bz2");
  write("a.bag", first.closed());
  BagWriter second;
  second.add(second.connect("/x", kTwist), 40, twist_message(1, 4));
  second.end_chunk();
  write("b.bag", second.closed());
  EXPECT_THAT(speeds(*make("{ topic: /x, sensor: a }", "file: [a.bag, b.bag]")), ElementsAre(1, 2, 3, 4, 5));
}

TEST_F(Rosbag1, StampsCanBeTakenFromTheRecordAndBeMoved) {
  const auto recorded = one(kTwist, twist_message(0, 1), ", stamp: recorded");
  EXPECT_EQ(recorded.at(0).stamp.time_since_epoch().count(), 5 * kSecond);
  EXPECT_THAT(one(kTwist, twist_message(0, 1)), IsEmpty());
  EXPECT_THAT(bad_, AllOf(HasSubstr("header has no stamp"), HasSubstr("stamp: recorded")));
  const auto moved = one(kTwist, twist_message(4 * kSecond, 1), ", stamp_offset_s: -0.25");
  EXPECT_EQ(moved.at(0).stamp.time_since_epoch().count(), 3'750'000'000);
  EXPECT_EQ(moved.at(0).arrival.time_since_epoch().count(), 5 * kSecond);
  EXPECT_THAT(one(kTwist, twist_message(6 * kSecond, 1)), IsEmpty());
  EXPECT_THAT(bad_, HasSubstr("1.000000 s after it was recorded"));
}

TEST_F(Rosbag1, StampsMayLieSlightlyAfterTheirRecording) {
  const auto ahead = one(kTwist, twist_message(5 * kSecond + 8'000'000, 1));
  ASSERT_THAT(ahead, SizeIs(1));
  EXPECT_EQ(ahead[0].stamp.time_since_epoch().count(), 5'008'000'000);
  EXPECT_EQ(ahead[0].arrival.time_since_epoch().count(), 5 * kSecond);
  BagWriter bag;
  bag.add(bag.connect("/x", kTwist), 5 * kSecond, twist_message(5 * kSecond + 8'000'000, 1));
  bag.end_chunk();
  write_bag(bag);
  const auto strict = make("{ topic: /x, sensor: a }", "file: a.bag\nmax_bad_records: 1\nmax_ahead_s: 0.007");
  EXPECT_THAT(read_all(*strict), IsEmpty());
  EXPECT_THAT(strict->bad_records().at(0).reason,
              HasSubstr("its stamp lies 0.008000 s after it was recorded; max_ahead_s is 0.007"));
}

TEST_F(Rosbag1, TheSignOfAnAxisCanBeTurned) {
  const auto imu = one(kImu, imu_message(kSecond, {}), ", negate: [w_z_radps, f_x_mps2]");
  EXPECT_EQ(imu.at(0).as<ImuSample>().w_sensor, Eigen::Vector3d(0.1, 0.2, -0.3));
  const auto twist = one(kTwist, twist_message(kSecond, 1.5), ", negate: v_x_mps");
  EXPECT_EQ(twist.at(0).as<BodyTwist>().v_x_mps, -1.5);
}

TEST_F(Rosbag1, OnlyNumbersWithASignCanBeTurned) {
  const auto error = [this](const std::string& names) -> std::string {
    try {
      one(kImu, imu_message(kSecond, {}), ", negate: " + names);
    } catch (const ConfigError& refusal) {
      return refusal.what();
    }
    return "";
  };
  EXPECT_THAT(error("[w_z_radp]"), AllOf(HasSubstr("negate"), HasSubstr("did you mean \"w_z_radps\"?")));
  EXPECT_THAT(error("q_z"), HasSubstr("ImuSample has no number \"q_z\" with a sign"));
}

TEST_F(Rosbag1, MessagesCanArriveWithTheirStamps) {
  BagWriter bag;
  const auto slow = bag.connect("/slow", kTwist);
  const auto fast = bag.connect("/fast", kTwist);
  for (int k = 1; k <= 5; ++k) {
    bag.add(fast, k * kSecond, twist_message(k * kSecond, k));
    bag.add(slow, k * kSecond + 1, twist_message(k * kSecond - kSecond / 2, k - 0.5));
  }
  bag.add(slow, 9 * kSecond, twist_message(3 * kSecond, 99));
  bag.end_chunk();
  write_bag(bag);
  const auto source = make("{ topic: /fast, sensor: a }, { topic: /slow, sensor: b }",
                           "file: a.bag\narrival: stamp\nreorder_window_s: 0.6\nmax_bad_records: 1");
  const auto all = read_all(*source);
  ASSERT_THAT(all, SizeIs(10));
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(all[i].as<BodyTwist>().v_x_mps, 0.5 * static_cast<double>(i + 1));
    EXPECT_EQ(all[i].arrival, all[i].stamp);
    EXPECT_EQ(all[i].sequence, i);
  }
  ASSERT_THAT(source->bad_records(), SizeIs(1));
  EXPECT_THAT(source->bad_records()[0].reason, HasSubstr("reorder_window_s"));
}

}  // namespace
}  // namespace waymark
