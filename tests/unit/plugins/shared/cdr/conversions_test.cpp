// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/cdr/conversions.hpp"

#include <gmock/gmock.h>

#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

#include "plugins/shared/cdr/message.hpp"
#include "plugins/shared/cdr/message_kinds.hpp"
#include "plugins/shared/cdr/to_ros.hpp"
#include "unit/plugins/shared/cdr/timed_cloud.hpp"

namespace waymark::ros_test {
namespace {

using ros::Unusable;
using testing::ElementsAre;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();
const ros::std_msgs::Header kHeader{{1'700'000'000, 500}, "sensor"};

TEST(Conversions, AnImuSurvivesBothWays) {
  ImuSample sample;
  sample.w_sensor = {0.1, -0.2, 0.3};
  sample.q_enu_sensor = {0.5, 0.5, -0.5, 0.5};
  const auto again = ros::to_imu_sample(ros::to_ros(sample, kHeader));
  EXPECT_EQ(again->w_sensor, sample.w_sensor);
  EXPECT_TRUE(again->f_sensor.array().isNaN().all());
  EXPECT_EQ(again->q_enu_sensor.coeffs(), sample.q_enu_sensor.coeffs());
  EXPECT_EQ(again->problem(), "");
}

TEST(Conversions, AFixSurvivesBothWays) {
  GnssFix fix;
  fix.latitude_deg = 47.5;
  fix.longitude_deg = 8.5;
  fix.height_m = 400.0;
  fix.sigma_horizontal_m = 0.5;
  fix.sigma_vertical_m = 2.0;
  fix.type = GnssFix::Type::differential;
  const auto again = ros::to_gnss_fix(ros::to_ros(fix, kHeader));
  EXPECT_EQ(again->latitude_deg, 47.5);
  EXPECT_EQ(again->height_m, 400.0);
  EXPECT_DOUBLE_EQ(again->sigma_horizontal_m, 0.5);
  EXPECT_DOUBLE_EQ(again->sigma_vertical_m, 2.0);
  EXPECT_EQ(again->type, fix.type);
}

TEST(Conversions, ACloudSurvivesBothWays) {
  PointCloud cloud;
  cloud.points_m = {{1.0f, 2.0f, 3.0f}, {-4.0f, 5.0f, 0.5f}};
  cloud.offsets_s = {0.0f, 0.001f};
  cloud.intensities = {7.0f, 8.0f};
  const auto message = ros::to_ros(cloud, kHeader);
  EXPECT_EQ(message.point_step, 20U);
  const auto again = ros::to_point_cloud(ros::from_cdr<ros::sensor_msgs::PointCloud2>(ros::to_cdr(message)));
  EXPECT_EQ(again->points_m, cloud.points_m);
  EXPECT_EQ(again->intensities, cloud.intensities);
  ASSERT_EQ(again->offsets_s.size(), 2U);
  EXPECT_NEAR(again->offsets_s[1], 0.001f, 1e-9f);
}

/// Points of x, y, z as float64, big endian, with seconds since 1970 behind them, in padded rows.
ros::sensor_msgs::PointCloud2 odd_cloud(std::vector<std::array<double, 4>> points, std::uint32_t height) {
  ros::sensor_msgs::PointCloud2 message;
  message.header = kHeader;
  std::uint32_t offset = 0;
  for (const char* name : {"z", "y", "x", "timestamp"}) {
    message.fields.push_back({name, offset, 8, 1});
    offset += 8;
  }
  message.is_bigendian = true;
  message.point_step = 36;
  message.height = height;
  message.width = static_cast<std::uint32_t>(points.size()) / height;
  message.row_step = message.width * message.point_step + 5;
  message.data.resize(std::size_t{message.row_step} * height);
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::uint8_t* at = message.data.data() + i / message.width * message.row_step + i % message.width * 36;
    for (const double value : points[i]) {
      const auto bits = std::bit_cast<std::uint64_t>(value);
      for (int byte = 7; byte >= 0; --byte) *at++ = static_cast<std::uint8_t>(bits >> (8 * byte));
    }
  }
  return message;
}

TEST(Conversions, CloudsOfOtherLayoutsAreRead) {
  const double stamp = 1'700'000'000.0000005;
  const auto cloud = ros::to_point_cloud(
      odd_cloud({{3.0, 2.0, 1.0, stamp + 0.25}, {6.0, 5.0, 4.0, stamp + 0.5}, {1.0, 1.0, std::nan(""), stamp}, {}}, 2));
  ASSERT_EQ(cloud->points_m.size(), 3U) << "one is not finite";
  EXPECT_EQ(cloud->points_m[0], Eigen::Vector3f(1.0f, 2.0f, 3.0f));
  EXPECT_EQ(cloud->points_m[1], Eigen::Vector3f(4.0f, 5.0f, 6.0f));
  EXPECT_NEAR(cloud->offsets_s[0], 0.25f, 1e-6f);
  EXPECT_NEAR(cloud->offsets_s[1], 0.5f, 1e-6f);
}

TEST(Conversions, ACloudWhoseSizesDoNotFitIsUnusable) {
  const auto good = odd_cloud({{3.0, 2.0, 1.0, 0.0}, {6.0, 5.0, 4.0, 0.0}}, 1);
  EXPECT_NO_THROW(ros::to_point_cloud(good));
  auto bad = good;
  bad.width = 0xffff'ffff;
  EXPECT_THROW(ros::to_point_cloud(bad), Unusable);
  bad = good;
  bad.height = 0xffff'ffff;
  EXPECT_THROW(ros::to_point_cloud(bad), Unusable);
  bad = good;
  bad.point_step = 0;
  EXPECT_THROW(ros::to_point_cloud(bad), Unusable);
  bad = good;
  bad.fields[0].offset = 29;
  EXPECT_THROW(ros::to_point_cloud(bad), Unusable);
  bad = good;
  bad.fields[0].offset = 0xffff'fff9;
  EXPECT_THROW(ros::to_point_cloud(bad), Unusable);
  bad = good;
  bad.fields[2].datatype = 9;
  EXPECT_THROW(ros::to_point_cloud(bad), Unusable);
  bad = good;
  bad.fields.erase(bad.fields.begin());
  EXPECT_THROW(ros::to_point_cloud(bad), Unusable);
}

TEST(Conversions, TimesOfPointsAreReadAsDriversWriteThem) {
  const auto offsets = [](const char* name, PointType type, const std::vector<double>& times) {
    return ros::to_point_cloud(timed_cloud(kHeader, name, type, times))->offsets_s;
  };
  using testing::FloatNear;
  constexpr double kStamp_s = 1'700'000'000.0000005;
  EXPECT_THAT(offsets("t", kUint32, {0, 1e8}), ElementsAre(0.0f, 0.1f));     // Ouster
  EXPECT_THAT(offsets("offset_time", kUint32, {5e6}), ElementsAre(0.005f));  // Livox
  EXPECT_THAT(offsets("t", kInt32, {-5e7, 5e7}), ElementsAre(-0.05f, 0.05f));
  EXPECT_THAT(offsets("time", kFloat32, {-0.1, 0.0}), ElementsAre(-0.1f, 0.0f));  // Velodyne
  EXPECT_THAT(offsets("timestamp", kFloat64, {kStamp_s, kStamp_s + 0.05}),        // Hesai, RoboSense
              ElementsAre(FloatNear(0.0f, 1e-6f), FloatNear(0.05f, 1e-6f)));
  EXPECT_THAT(offsets("timestamp", kFloat64, {1e9 * kStamp_s - 1e7, 1e9 * kStamp_s + 1e7}),  // Livox, its second driver
              ElementsAre(FloatNear(-0.01f, 1e-6f), FloatNear(0.01f, 1e-6f)));
  EXPECT_THAT(offsets("moment", kFloat32, {0.1}), testing::IsEmpty());
}

TEST(Conversions, ATimeOfAPointFarFromTheStampIsUnusable) {
  const auto unusable = [](PointType type, double time) {
    EXPECT_THROW(ros::to_point_cloud(timed_cloud(kHeader, "timestamp", type, {time})), Unusable) << time;
  };
  unusable(kFloat64, 1'600'000'000.0);
  unusable(kFloat32, 61.0);
  unusable(kFloat64, std::nan(""));
  unusable(kFloat32, -std::numeric_limits<double>::infinity());
  unusable(kFloat64, 1e300);
}

TEST(Conversions, ACloudOfEmptyRowsIsUnusable) {
  ros::sensor_msgs::PointCloud2 cloud;
  cloud.point_step = 16;
  cloud.height = 2;
  cloud.width = 0;
  cloud.row_step = 0;
  EXPECT_THROW(ros::to_point_cloud(cloud), Unusable);
}

TEST(Conversions, AScanSurvivesBothWays) {
  LaserScan scan;
  scan.start_rad = -1.5;
  scan.step_rad = 0.25;
  scan.ranges_m = {1.0f, kInfinity, 3.0f};
  scan.intensities = {1.0f, 2.0f, 3.0f};
  const auto message = ros::to_ros(scan, kHeader, 0.1f, 30.0f);
  EXPECT_EQ(message.angle_max, -1.0f);
  const auto again = ros::to_laser_scan(message);
  EXPECT_EQ(again->start_rad, scan.start_rad);
  EXPECT_EQ(again->ranges_m, scan.ranges_m);
  EXPECT_EQ(again->intensities, scan.intensities);
}

TEST(Conversions, ReturnsThatAreNoneAreAsRep117HasThem) {
  ros::sensor_msgs::LaserScan message;
  message.angle_increment = 0.1f;
  message.ranges = {-kInfinity, kNaN, kInfinity, 2.0f};
  EXPECT_THAT(ros::to_laser_scan(message)->ranges_m, ElementsAre(0.0f, kInfinity, kInfinity, 2.0f));
}

TEST(Conversions, ImagesSurviveBothWays) {
  Image image;
  image.encoding = Image::Encoding::bgr8;
  image.width = 2;
  image.height = 1;
  image.data = {1, 2, 3, 4, 5, 6};
  EXPECT_EQ(ros::to_image(ros::to_ros(image, kHeader))->data, image.data);
  image.encoding = Image::Encoding::compressed;
  image.data = {0x89, 'P', 'N', 'G'};
  EXPECT_EQ(ros::to_ros_compressed(image, kHeader).format, "png");
  EXPECT_EQ(ros::to_image(ros::to_ros_compressed(image, kHeader))->data, image.data);
}

TEST(Conversions, TheMeanOfTheWheelsOfASideCounts) {
  const ros::WheelJoints joints{{"fl", "rl"}, {"fr"}, 0.5};
  ros::sensor_msgs::JointState message{kHeader, {"fr", "fl", "arm", "rl"}, {}, {4.0, 1.0, 9.0, 3.0}, {}};
  const auto speeds = ros::to_wheel_speeds(message, joints);
  EXPECT_DOUBLE_EQ(speeds->left_mps, 1.0);
  EXPECT_DOUBLE_EQ(speeds->right_mps, 2.0);
  const auto again = ros::to_wheel_speeds(ros::to_ros(*speeds, kHeader, joints), joints);
  EXPECT_DOUBLE_EQ(again->left_mps, 1.0);
  message.velocity.pop_back();
  EXPECT_THROW(ros::to_wheel_speeds(message, joints), Unusable);
  message.name.erase(message.name.begin());
  EXPECT_THROW(ros::to_wheel_speeds(message, joints), Unusable);
}

TEST(Conversions, IncrementsLeadFromPoseToPose) {
  ros::IncrementsOfPoses poses;
  ros::geometry_msgs::Pose pose;
  pose.position = {1.0, 1.0, 0.0};
  const double half = std::numbers::pi / 4.0;
  pose.orientation = {0.0, 0.0, std::sin(half), std::cos(half)};  // to the north
  EXPECT_FALSE(poses.add(Time(std::chrono::seconds(1)), pose));
  pose.position = {0.0, 3.0, 0.0};
  const auto increment = poses.add(Time(std::chrono::seconds(3)), pose);
  ASSERT_TRUE(increment);
  EXPECT_EQ(increment->stamp, Time(std::chrono::seconds(1)));
  EXPECT_DOUBLE_EQ(increment->payload->interval_s, 2.0);
  EXPECT_NEAR(increment->payload->x_m, 2.0, 1e-12);
  EXPECT_NEAR(increment->payload->y_m, 1.0, 1e-12);
  EXPECT_THROW(poses.add(Time(std::chrono::seconds(3)), pose), Unusable);
  pose.orientation = {0.0, 0.0, 0.0, 0.0};
  EXPECT_THROW(poses.add(Time(std::chrono::seconds(4)), pose), Unusable);
}

TEST(Conversions, StampsKeepTheirNanoseconds) {
  const Time stamp{Duration{1'700'000'000'123'456'789}};
  EXPECT_EQ(ros::to_time(ros::to_ros_time(stamp)), stamp);
  EXPECT_FALSE(ros::to_time({}));
  EXPECT_EQ(ros::to_ros_time(Time{Duration{-5}}), ros::builtin_interfaces::Time());
}

TEST(MessageKinds, EveryKindDecodesItsOwnDefault) {
  const Config entry = Config::parse("wheels: { left: [l], right: [r], radius_m: 0.1 }");
  const ros::DecoderSettings settings = ros::read_decoder_settings(entry);
  for (const ros::MessageKind& kind : ros::message_kinds()) {
    EXPECT_NE(make_payload(kind.payload), nullptr) << kind.payload;
    EXPECT_EQ(kind.ros1_md5.size(), 32U) << kind.type;
    const ros::Decoder decode = kind.make(settings, entry);
    // Nothing but the encapsulation.
    EXPECT_THROW(decode(ros::WireReader::cdr(std::vector<std::uint8_t>{0, 1, 0, 0})), Unusable) << kind.type;
  }
}

TEST(MessageKinds, JointsNeedTheirWheels) {
  const Config entry = Config::parse("{}");
  for (const ros::MessageKind& kind : ros::message_kinds()) {
    if (kind.type != ros::sensor_msgs::JointState::kType) continue;
    EXPECT_THROW(kind.make(ros::read_decoder_settings(entry), entry), ConfigError);
  }
}

}  // namespace
}  // namespace waymark::ros_test
