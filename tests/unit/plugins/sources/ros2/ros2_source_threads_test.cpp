// SPDX-License-Identifier: Apache-2.0
// The source ros2 with publishers in the same process.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "dds_domain.hpp"
#include "live_source.hpp"
#include "plugins/shared/cdr/message.hpp"
#include "plugins/shared/cdr/payload_cdr.hpp"
#include "plugins/shared/cdr/ros/geometry_msgs.hpp"
#include "plugins/shared/cdr/ros/sensor_msgs.hpp"
#include "plugins/shared/cdr/to_ros.hpp"
#include "plugins/shared/dds/writer.hpp"
#include "waymark/base/error.hpp"
#include "waymark/interface/command.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/interface/source.hpp"
#include "waymark/plugin_loader.hpp"

namespace waymark {
namespace {

using test::LiveReader;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr dds::Quality kLatched{.reliable = true, .latched = true, .depth = 1};
constexpr std::chrono::milliseconds kPatience{100};

Rig rig() {
  return Rig({{"imu", std::string(ImuSample::kType), {}},
              {"lidar", std::string(LaserScan::kType), {}},
              {"camera", std::string(Image::kType), {}},
              {"wheels", std::string(BodyTwist::kType), {}},
              {"compass", std::string(CompassHeading::kType), {}}});
}

std::shared_ptr<Source> make_source(const std::string& channels, const std::string& more = "") {
  const std::string yaml = fmt::format("{{ domain: {}, channels: [ {} ]{} }}", test::own_domain(), channels,
                                       more.empty() ? "" : ", " + more);
  return PluginLoader({WAYMARK_PLUGIN_DIR}).create<Source>("ros2", Config::parse(yaml, "robot.yaml"), rig());
}

const std::string kImu = "{ topic: /imu, type: sensor_msgs/msg/Imu, sensor: imu }";
const std::string kScan = "{ topic: /scan, type: sensor_msgs/msg/LaserScan, sensor: lidar }";

Time at(double seconds) { return Time{from_seconds(1.7e9 + seconds)}; }

ros::sensor_msgs::Imu imu(double seconds) {
  ros::sensor_msgs::Imu message;
  message.header = ros::to_ros_header(at(seconds), "imu_link");
  message.angular_velocity.z = 0.5;
  return message;
}

template <ros::Message M>
class Topic {
 public:
  Topic(const dds::Participant& participant, const std::string& name, const dds::Quality& quality = {})
      : writer_(participant, name, std::string(M::kType), quality, kPatience) {}
  void wait_for_reader() {
    ASSERT_TRUE(test::eventually([this] { return writer_.readers() > 0; }));
  }
  void write(const M& message) { writer_.write(ros::to_cdr(message)); }
  dds::Writer& writer() { return writer_; }

 private:
  dds::Writer writer_;
};

class Ros2Source : public ::testing::Test {
 protected:
  dds::Participant robot_{{test::own_domain(), "lo"}};
};

TEST_F(Ros2Source, DeliversMessagesWithTheStampsOfTheirHeaders) {
  LiveReader reader(make_source(kImu));
  Topic<ros::sensor_msgs::Imu> topic(robot_, "/imu");
  topic.wait_for_reader();
  topic.write(imu(0.25));
  topic.write(imu(0.5));
  ASSERT_TRUE(reader.wait_for(2));
  const auto measurements = reader.measurements();
  EXPECT_EQ(measurements[0].stamp, at(0.25));
  EXPECT_EQ(measurements[1].stamp, at(0.5));
  EXPECT_EQ(measurements[1].sequence, 1U);
  EXPECT_EQ(measurements[0].as<ImuSample>().w_sensor.z(), 0.5);
  EXPECT_TRUE(reader.wait_for_event("/imu: connected"));
}

TEST_F(Ros2Source, AMessageWithoutStampOrWithStampArrivalHasNone) {
  LiveReader reader(make_source("{ topic: /imu, type: sensor_msgs/Imu, sensor: imu, stamp: arrival }"));
  Topic<ros::sensor_msgs::Imu> topic(robot_, "/imu");
  topic.wait_for_reader();
  topic.write(imu(0.25));
  ASSERT_TRUE(reader.wait_for(1));
  EXPECT_EQ(reader.measurements()[0].stamp, kUnknownStamp);
}

TEST_F(Ros2Source, AMalformedMessageIsCountedAndTheNextOneIsRead) {
  const auto source = make_source(kImu);
  LiveReader reader(source);
  Topic<ros::sensor_msgs::Imu> topic(robot_, "/imu");
  topic.wait_for_reader();
  auto cut = ros::to_cdr(imu(0.0));
  cut.resize(cut.size() / 2);
  topic.writer().write(cut);
  topic.writer().write({0, 1, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 255, 255, 255, 127});  // a text of 2 GiB
  topic.writer().write({0, 7, 0, 0, 1, 2, 3, 4});                                  // no XCDR1
  topic.writer().write({});
  topic.write(imu(1.0));
  ASSERT_TRUE(reader.wait_for(1));
  EXPECT_EQ(reader.measurements()[0].stamp, at(1.0));
  EXPECT_TRUE(reader.wait_for_event("1 bad message so far; /imu, message 1: ends early"));
  reader.stop();
  ASSERT_EQ(source->bad_records().size(), 4U);
  EXPECT_EQ(source->bad_records()[3].place, "/imu, message 4");
}

TEST_F(Ros2Source, AMessageThatIsTooLargeIsABadOne) {
  const auto source = make_source(kScan, "max_message_bytes: 1000");
  LiveReader reader(source);
  Topic<ros::sensor_msgs::LaserScan> topic(robot_, "/scan");
  topic.wait_for_reader();
  ros::sensor_msgs::LaserScan scan;
  scan.header = ros::to_ros_header(at(0.0), "laser");
  scan.angle_increment = 0.01f;
  scan.ranges.assign(1000, 1.0f);
  topic.write(scan);
  EXPECT_TRUE(reader.wait_for_event("max_message_bytes is 1000"));
}

TEST_F(Ros2Source, APublisherThatGoesAndComesBackIsReported) {
  LiveReader reader(make_source(kImu));
  {
    const Topic<ros::sensor_msgs::Imu> topic(robot_, "/imu");
    EXPECT_TRUE(reader.wait_for_event("/imu: connected"));
  }
  EXPECT_TRUE(reader.wait_for_event("/imu: lost: nobody publishes it"));
  const Topic<ros::sensor_msgs::Imu> topic(robot_, "/imu");
  EXPECT_TRUE(reader.wait_for_event("/imu: restored"));
}

TEST_F(Ros2Source, AnotherTypeOnTheTopicIsReported) {
  LiveReader reader(make_source(kImu));
  const Topic<ros::sensor_msgs::MagneticField> topic(robot_, "/imu");
  EXPECT_TRUE(
      reader.wait_for_event("/imu: nobody publishes sensor_msgs/msg/Imu; there is sensor_msgs/msg/MagneticField"));
}

TEST_F(Ros2Source, APoseOfRVizIsACommandInItsPlaceAmongTheMeasurements) {
  const auto source = make_source(kImu);
  ASSERT_EQ(source->channels().size(), 2U);
  EXPECT_EQ(source->channels()[1].payload_type, Command::kType);
  LiveReader reader(source);
  Topic<ros::sensor_msgs::Imu> topic(robot_, "/imu");
  Topic<ros::geometry_msgs::PoseWithCovarianceStamped> pose(robot_, "/initialpose");
  topic.wait_for_reader();
  pose.wait_for_reader();
  topic.write(imu(0.0));
  ros::geometry_msgs::PoseWithCovarianceStamped message;
  message.header.frame_id = "map";
  message.pose.pose.position.x = 3.0;
  pose.write(message);
  topic.write(imu(1.0));
  ASSERT_TRUE(reader.wait_for(3));
  const auto measurements = reader.measurements();
  ASSERT_EQ(measurements[1].sensor, 1U);
  EXPECT_EQ(measurements[1].as<Command>().text, "set-pose 3 0 0");
}

TEST_F(Ros2Source, APayloadOfWaymarkHasTheStampOfItsWriter) {
  LiveReader reader(make_source("{ topic: /compass, type: waymark_msgs/msg/CompassHeading, sensor: compass }"));
  dds::Writer writer(robot_, "/compass", "waymark_msgs/msg/CompassHeading", {}, kPatience);
  ASSERT_TRUE(test::eventually([&] { return writer.readers() > 0; }));
  CompassHeading heading;
  writer.write(ros::payload_to_cdr(heading), at(7.0));
  ASSERT_TRUE(reader.wait_for(1));
  EXPECT_EQ(reader.measurements()[0].stamp, at(7.0));
  EXPECT_EQ(reader.measurements()[0].payload->type(), CompassHeading::kType);
}

TEST_F(Ros2Source, TheSimulatedTimeIsThatOfTheClock) {
  const auto source = make_source(kImu, "use_sim_time: true");
  EXPECT_EQ(source->simulated_time(), Time{});
  LiveReader reader(source);
  Topic<ros::sensor_msgs::Imu> topic(robot_, "/imu");
  Topic<ros::rosgraph_msgs::Clock> clock(robot_, "/clock");
  topic.wait_for_reader();
  clock.wait_for_reader();
  topic.write(imu(0.0));  // before the clock began: nobody knows when that is
  clock.write({{12, 500'000'000}});
  ASSERT_TRUE(test::eventually([&] { return source->simulated_time() == Time{from_seconds(12.5)}; }));
  topic.write(imu(1.0));
  ASSERT_TRUE(reader.wait_for(1));
  EXPECT_EQ(reader.measurements()[0].stamp, at(1.0));
  clock.write({{3, 0}});
  EXPECT_TRUE(reader.wait_for_event("/clock went back by 9.500 s"));
  EXPECT_FALSE(make_source(kScan)->simulated_time());
}

ros::tf2_msgs::TFMessage mounted(const std::string& frame, double x, const ros::geometry_msgs::Quaternion& q) {
  ros::geometry_msgs::TransformStamped transform;
  transform.header.frame_id = "base_link";
  transform.child_frame_id = frame;
  transform.transform = {{x, 0.0, 0.0}, q};
  return {{transform}};
}

TEST_F(Ros2Source, LearnsFromTfWhereASensorIsMounted) {
  const auto source = make_source(kScan);
  Topic<ros::tf2_msgs::TFMessage> tf(robot_, "/tf_static", kLatched);
  tf.write(mounted("laser", 0.25, {0.0, 0.0, 1.0, 0.0}));
  Topic<ros::sensor_msgs::LaserScan> topic(robot_, "/scan");
  topic.wait_for_reader();
  ros::sensor_msgs::LaserScan scan;
  scan.header = ros::to_ros_header(at(0.0), "laser");
  topic.write(scan);
  const auto pose = source->T_base_sensor("lidar");
  ASSERT_TRUE(pose);
  EXPECT_NEAR(pose->p.x(), 0.25, 1e-12);
  EXPECT_NEAR(std::abs(pose->yaw()), std::numbers::pi, 1e-12);
  EXPECT_FALSE(source->T_base_sensor("gps"));
}

TEST_F(Ros2Source, TheFrameOfAPictureLooksAlongZ) {
  const auto source =
      make_source("{ topic: /camera, type: sensor_msgs/msg/Image, sensor: camera, frame: camera_optical }");
  Topic<ros::tf2_msgs::TFMessage> tf(robot_, "/tf_static", kLatched);
  tf.write(mounted("camera_optical", 0.1, {-0.5, 0.5, -0.5, 0.5}));  // looks ahead
  const auto pose = source->T_base_sensor("camera");
  ASSERT_TRUE(pose);
  EXPECT_NEAR(pose->q.angularDistance(Eigen::Quaterniond::Identity()), 0.0, 1e-9);
}

TEST_F(Ros2Source, WithoutATransformItSaysWhichFramesThereAre) {
  const auto source = make_source("{ topic: /scan, type: sensor_msgs/msg/LaserScan, sensor: lidar, frame: laser }",
                                  "tf_patience_s: 0.5");
  Topic<ros::tf2_msgs::TFMessage> tf(robot_, "/tf_static", kLatched);
  tf.write(mounted("lidar", 0.1, {}));
  try {
    source->T_base_sensor("lidar");
    FAIL() << "it is found";
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), HasSubstr("did not connect laser with base_link"));
    EXPECT_THAT(error.what(), HasSubstr("lidar (in base_link)"));
  }
}

TEST_F(Ros2Source, EndsSoonWhenItIsStopped) {
  EXPECT_TRUE(test::ends_soon([] { return LiveReader(make_source(kImu)).stop(); }));
}

std::string error_of(const std::string& channels, const std::string& more = "") {
  try {
    make_source(channels, more);
    return "none";
  } catch (const ConfigError& error) {
    return error.what();
  }
}

TEST_F(Ros2Source, RefusesWhatCannotBeReadByName) {
  EXPECT_THAT(error_of("{ topic: /imu, type: sensor_msgs/msg/Imo, sensor: imu }"),
              HasSubstr("did you mean \"sensor_msgs/msg/Imu\"?"));
  EXPECT_THAT(error_of("{ topic: \"/imu data\", type: sensor_msgs/msg/Imu, sensor: imu }"),
              HasSubstr("is no topic of ROS"));
  EXPECT_THAT(error_of("{ topic: /odom, type: nav_msgs/msg/Odometry, payload: LaserScan, sensor: wheels }"),
              HasSubstr("BodyTwist or Height or PoseIncrement is expected"));
  EXPECT_THAT(error_of(kImu + ", " + kImu), HasSubstr("two sensors on one input"));
  EXPECT_THAT(error_of("{ topic: /imu, type: sensor_msgs/msg/Imu, sensor: lidar }"), HasSubstr("lidar"));
  EXPECT_THAT(error_of("{ topic: /imu, type: sensor_msgs/msg/Imu, sensor: imu, qos: best }"), HasSubstr("qos"));
  EXPECT_THAT(error_of(kImu, "interface: nowhere7"), HasSubstr("interface"));
}

}  // namespace
}  // namespace waymark
