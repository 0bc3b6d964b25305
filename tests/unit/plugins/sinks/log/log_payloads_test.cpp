// SPDX-License-Identifier: Apache-2.0
// needs plugins: csv
// Every payload comes back from a log as it went in.
#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "log_fixture.hpp"

namespace waymark {
namespace {

using LogPayloads = test::LogSink;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

TEST_F(LogPayloads, NumbersComeBackBitForBit) {
  start();
  const std::vector<double> numbers{0.1, -0.0, 1.0 / 3.0, 5e-324, 1.7976931348623157e308, 123456789.123456789, -2.0};
  for (std::size_t i = 0; i < numbers.size(); ++i) arrive(0, wheels(numbers[i]), static_cast<std::int64_t>(i));
  const auto got = same_order<WheelSpeeds>();
  ASSERT_EQ(got.size(), numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    EXPECT_EQ(got[i].left_mps, numbers[i]);
    EXPECT_EQ(std::signbit(got[i].left_mps), std::signbit(numbers[i]));
  }
}

TEST_F(LogPayloads, ScansComeBackBitForBit) {
  start();
  LaserScan one = scan({0.1F, 16777217.0F, 1e-38F, kInfinity}, -2.356194490192345);
  one.intensities = {0.0F, 1.0F / 3.0F, 3e38F, 7.0F};
  one.beam_interval_s = 1.0 / 10240.0;
  arrive(1, one, 5);
  const auto got = same_order<LaserScan>();
  ASSERT_EQ(got.size(), 1u);
  EXPECT_EQ(got[0].start_rad, one.start_rad);
  EXPECT_EQ(got[0].step_rad, one.step_rad);
  EXPECT_EQ(got[0].beam_interval_s, one.beam_interval_s);
  EXPECT_EQ(got[0].ranges_m, one.ranges_m);
  EXPECT_EQ(got[0].intensities, one.intensities);
  EXPECT_TRUE(out_.has("log/front_lidar.csv")) << "a blank does not belong into the name of a file";
}

TEST_F(LogPayloads, AnotherScanGeometryGetsAnotherFile) {
  start();
  arrive(1, scan({1, 2, 3}), 0);
  arrive(1, scan({1, 2}), 1);
  arrive(1, scan({4, 5, 6}), 2);
  arrive(1, scan({4, 5, 6}, 0.3), 3);
  const auto got = same_order<LaserScan>();
  ASSERT_EQ(got.size(), 4u);
  EXPECT_THAT(got[1].ranges_m, ElementsAre(1, 2));
  EXPECT_THAT(got[2].ranges_m, ElementsAre(4, 5, 6));
  EXPECT_EQ(got[3].start_rad, 0.3);
  EXPECT_THAT(out_.lines("log/front_lidar.csv"), SizeIs(3));
  EXPECT_TRUE(out_.has("log/front_lidar_2.csv"));
  EXPECT_TRUE(out_.has("log/front_lidar_3.csv"));
}

TEST_F(LogPayloads, UnknownFieldsOfAFixStayUnknown) {
  start();
  GnssFix local;
  local.p_map_antenna.head<2>() << 1.5, -2.0;
  local.type = GnssFix::Type::rtk_float;
  GnssFix geodetic;
  geodetic.latitude_deg = -33.888;
  geodetic.longitude_deg = 151.19;
  geodetic.satellites = 0;
  geodetic.hdop = 1.25;
  geodetic.speed_mps = 0.1;
  geodetic.course_rad = 6.2;
  arrive(3, local, 0);
  arrive(3, geodetic, 1);
  arrive(3, GnssFix{}, 2);
  const auto got = same_order<GnssFix>();
  ASSERT_EQ(got.size(), 3u);
  EXPECT_EQ(got[0].p_map_antenna.head<2>(), local.p_map_antenna.head<2>());
  EXPECT_TRUE(std::isnan(got[0].p_map_antenna.z()) && std::isnan(got[0].latitude_deg) && std::isnan(got[0].hdop));
  EXPECT_EQ(got[0].satellites, -1);
  EXPECT_EQ(got[0].type, GnssFix::Type::rtk_float);
  EXPECT_TRUE(std::isnan(got[1].p_map_antenna.x()));
  EXPECT_EQ(got[1].latitude_deg, -33.888);
  EXPECT_EQ(got[1].satellites, 0);
  EXPECT_EQ(got[1].hdop, 1.25);
  EXPECT_EQ(got[1].type, GnssFix::Type::unknown);
  EXPECT_EQ(got[1].speed_mps, 0.1);
  EXPECT_EQ(got[1].course_rad, 6.2);
  EXPECT_TRUE(std::isnan(got[0].speed_mps) && std::isnan(got[0].course_rad));
  EXPECT_EQ(out_.lines("log/gps.csv").at(1), "0,0,1.5,-2,,,,,,,,,3,,");
}

TEST_F(LogPayloads, WritesTheOtherPayloadsToo) {
  start();
  ImuSample gyroscope;
  gyroscope.w_sensor = {0.1, 0.2, -0.3};
  ImuSample nine = gyroscope;
  WheelSteering steering;
  steering.steering_rad = -0.2;
  BodyTwist twist;
  twist.v_y_mps = 0.25;
  CompassHeading heading;
  heading.heading_rad = 3.0;
  nine.f_sensor = {0.0, 0.5, 9.81};
  nine.m_sensor = {1e-6, 2e-5, -4.4e-5};
  arrive(0, steering, 1);
  arrive(0, twist, 2);
  PoseIncrement increment;
  increment.interval_s = 0.1;
  increment.x_m = 1.0 / 3.0;
  increment.y_m = -0.02;
  increment.yaw_rad = 0.3;
  arrive(2, heading, 3);
  arrive(3, gyroscope, 4);
  arrive(3, nine, 5);
  arrive(0, increment, 6);
  const std::vector<Measurement> got = read_back();
  ASSERT_EQ(got.size(), 6u);
  EXPECT_EQ(got[5].as<PoseIncrement>().interval_s, 0.1);
  EXPECT_EQ(got[5].as<PoseIncrement>().x_m, 1.0 / 3.0);
  EXPECT_EQ(got[5].as<PoseIncrement>().y_m, -0.02);
  EXPECT_EQ(got[5].as<PoseIncrement>().yaw_rad, 0.3);
  EXPECT_EQ(got[0].as<WheelSteering>().steering_rad, -0.2);
  EXPECT_EQ(got[1].as<BodyTwist>().v_y_mps, 0.25);
  EXPECT_EQ(got[2].as<CompassHeading>().heading_rad, 3.0);
  EXPECT_EQ(got[3].as<ImuSample>().w_sensor, nine.w_sensor);
  EXPECT_TRUE(got[3].as<ImuSample>().f_sensor.array().isNaN().all());
  EXPECT_EQ(got[4].as<ImuSample>().f_sensor, nine.f_sensor);
  EXPECT_EQ(got[4].as<ImuSample>().m_sensor, nine.m_sensor);
  EXPECT_TRUE(out_.has("log/wheels.csv") && out_.has("log/wheels_2.csv")) << "a sensor with two payload types";
}

TEST_F(LogPayloads, WhatDevicesTellOfThemselvesComesBack) {
  start();
  CompassHeading magnetic;
  magnetic.heading_rad = 0.1;
  CompassHeading by_satellites;
  by_satellites.heading_rad = 1.0 / 3.0;
  by_satellites.sigma_rad = 0.01;
  by_satellites.from_true_north = true;
  MagneticField field;
  field.m_sensor = {1e-6 / 3.0, -0.0, -4.4e-5};
  Height barometer;
  barometer.height_m = 0.7;
  Height ultrasound;
  ultrasound.height_m = -0.1;
  ultrasound.sigma_m = 0.03;
  ImuSample oriented;
  oriented.w_sensor = {0.1, 0.2, 0.3};
  oriented.q_enu_sensor = Eigen::Quaterniond(1.0, -2.0, 3.0, 0.1).normalized();
  ImuSample not_oriented;
  not_oriented.w_sensor = {0.1, 0.2, 0.3};
  arrive(0, magnetic, 1);
  arrive(0, by_satellites, 2);
  arrive(2, field, 3);
  arrive(3, barometer, 4);
  arrive(3, ultrasound, 5);
  arrive(2, oriented, 6);
  arrive(2, not_oriented, 7);
  const std::vector<Measurement> got = read_back();
  ASSERT_EQ(got.size(), 7u);
  EXPECT_TRUE(std::isnan(got[0].as<CompassHeading>().sigma_rad));
  EXPECT_FALSE(got[0].as<CompassHeading>().from_true_north);
  EXPECT_EQ(got[1].as<CompassHeading>().heading_rad, 1.0 / 3.0);
  EXPECT_EQ(got[1].as<CompassHeading>().sigma_rad, 0.01);
  EXPECT_TRUE(got[1].as<CompassHeading>().from_true_north);
  EXPECT_EQ(got[2].as<MagneticField>().m_sensor, field.m_sensor);
  EXPECT_TRUE(std::signbit(got[2].as<MagneticField>().m_sensor.y()));
  EXPECT_EQ(got[3].as<Height>().height_m, 0.7);
  EXPECT_TRUE(std::isnan(got[3].as<Height>().sigma_m));
  EXPECT_EQ(got[4].as<Height>().height_m, -0.1);
  EXPECT_EQ(got[4].as<Height>().sigma_m, 0.03);
  EXPECT_EQ(got[5].as<ImuSample>().q_enu_sensor.coeffs(), oriented.q_enu_sensor.coeffs());
  EXPECT_TRUE(got[6].as<ImuSample>().q_enu_sensor.coeffs().array().isNaN().all());
}

TEST_F(LogPayloads, WhatTheHostRefusesComesBack) {
  start();
  LandmarkObservations behind;
  behind.landmarks = {{.range_m = -3.5, .bearing_rad = -0.1}};
  arrive(2, behind, 1);
  const auto got = same_order<LandmarkObservations>();
  ASSERT_EQ(got.size(), 1u);
  EXPECT_EQ(got[0].landmarks.at(0).range_m, -3.5);
}

TEST_F(LogPayloads, SetsOfLandmarksStaySets) {
  start();
  LandmarkObservations two;
  two.landmarks = {{.range_m = 1.5, .bearing_rad = 0.1, .identity = 7},
                   {.range_m = 2.5, .bearing_rad = 0.2, .radius_m = 0.3}};
  LandmarkObservations one;
  one.landmarks = {{.range_m = 3.5, .bearing_rad = -0.1}};
  arrive(2, LandmarkObservations{}, 1);
  arrive(2, two, 2);
  arrive(2, one, 2);  // of the same time, but another set
  arrive(2, LandmarkObservations{}, 3);
  const auto got = same_order<LandmarkObservations>();
  ASSERT_EQ(got.size(), 4u);
  EXPECT_THAT(got[0].landmarks, IsEmpty());
  ASSERT_THAT(got[1].landmarks, SizeIs(2));
  EXPECT_EQ(got[1].landmarks[0].identity, 7);
  EXPECT_TRUE(std::isnan(got[1].landmarks[0].radius_m));
  EXPECT_EQ(got[1].landmarks[1].identity, -1);
  EXPECT_EQ(got[1].landmarks[1].radius_m, 0.3);
  EXPECT_THAT(got[2].landmarks, SizeIs(1));
  EXPECT_THAT(got[3].landmarks, IsEmpty());
}

TEST_F(LogPayloads, SetsOfRangesStaySets) {
  start();
  Ranges burst;
  burst.ranges = {{.beacon = 3, .range_m = 1.5}, {.beacon = 4, .range_m = -2.5, .reference = 3, .sigma_m = 0.1}};
  arrive(2, burst, 1);
  const auto got = same_order<Ranges>();
  ASSERT_EQ(got.size(), 1u);
  ASSERT_THAT(got[0].ranges, SizeIs(2));
  EXPECT_TRUE(std::isnan(got[0].ranges[0].sigma_m));
  EXPECT_EQ(got[0].ranges[1].reference, 3);
}

TEST_F(LogPayloads, ScansOfRadarsStayScans) {
  start();
  RadarTargets scan;
  scan.targets = {{.range_m = 1.5, .azimuth_rad = 0.1, .radial_mps = -3.0}};
  arrive(2, RadarTargets{}, 1);
  arrive(2, scan, 2);
  const auto got = same_order<RadarTargets>();
  ASSERT_EQ(got.size(), 2u);
  EXPECT_THAT(got[0].targets, IsEmpty());
  EXPECT_EQ(got[1].targets.at(0).radial_mps, -3.0);
}

TEST_F(LogPayloads, PixelsBecomePngAndComeBackTheSame) {
  start();
  Image colour = image(Image::Encoding::bgr8, {}, 5, 3);
  for (int i = 0; i < 45; ++i) colour.data.push_back(static_cast<std::uint8_t>(5 * i));
  Image grey = image(Image::Encoding::mono8, {0, 100, 200, 255}, 2, 2);
  arrive(2, colour, 1);
  arrive(2, grey, 2);
  const auto got = same_order<Image>();
  ASSERT_EQ(got.size(), 2u);
  const cv::Mat decoded = cv::imdecode(got[0].data, cv::IMREAD_UNCHANGED);
  ASSERT_EQ(decoded.total() * decoded.elemSize(), colour.data.size());
  EXPECT_TRUE(std::equal(colour.data.begin(), colour.data.end(), decoded.data));
  const cv::Mat decoded_grey = cv::imdecode(got[1].data, cv::IMREAD_UNCHANGED);
  ASSERT_EQ(decoded_grey.total() * decoded_grey.elemSize(), grey.data.size());
  EXPECT_TRUE(std::equal(grey.data.begin(), grey.data.end(), decoded_grey.data));
  EXPECT_THAT(out_.lines("log/camera.csv"),
              ElementsAre("t_ns,arrival_ns,file", "1,1,camera/000000.png", "2,2,camera/000001.png"));
}

TEST_F(LogPayloads, CompressedImagesAreWrittenAsTheyAre) {
  start();
  const Image jpeg = image(Image::Encoding::compressed, {0xff, 0xd8, 0x0a, 0x00});
  const Image png = image(Image::Encoding::compressed, {0x89, 'P', 'N', 'G'});
  const Image noise = image(Image::Encoding::compressed, {});
  arrive(2, jpeg, 1);
  arrive(2, png, 2);
  arrive(2, noise, 3);
  const auto got = same_order<Image>();
  ASSERT_EQ(got.size(), 3u);
  EXPECT_EQ(got[0].data, jpeg.data);
  EXPECT_EQ(got[1].data, png.data);
  EXPECT_EQ(got[2].data, noise.data);
  EXPECT_TRUE(out_.has("log/camera/000000.jpg") && out_.has("log/camera/000001.png"));
}

TEST_F(LogPayloads, AnImageWithoutAllItsPixelsIsAnError) {
  start();
  const Image half = image(Image::Encoding::bgr8, {1, 2, 3}, 5, 3);
  EXPECT_THAT(error_of([&] { arrive(2, half, 1); }), HasSubstr("3 bytes are not 5 x 3 pixels"));
}

TEST_F(LogPayloads, ScansThatNeverLookTheSameAreAnError) {
  start();
  const std::string error = error_of([&] {
    for (int i = 0; i < 100; ++i) arrive(1, scan({1, 2}, 0.001 * i), i);
  });
  EXPECT_THAT(error, AllOf(HasSubstr("front lidar"), HasSubstr("layouts")));
}

}  // namespace
}  // namespace waymark
