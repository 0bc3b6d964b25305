// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "mcap_fixture.hpp"
#include "plugins/shared/cdr/payload_cdr.hpp"
#include "plugins/shared/mcap/mcap_log.hpp"
#include "unit/plugins/shared/cdr/timed_cloud.hpp"

namespace waymark::mcap_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

constexpr std::int64_t kSecond = 1'000'000'000;

Time at(std::int64_t nanoseconds) { return Time{Duration{nanoseconds}}; }

TEST_F(McapSourceTest, TopicsBecomeMeasurementsOfTheirSensors) {
  TopicWriter file;
  file.add("/odom", 2 * kSecond, odometry(2 * kSecond - 5, 0.0, 0.25));
  file.add("/twist", 3 * kSecond, twist(3 * kSecond - 7, 2.0));
  ros::sensor_msgs::LaserScan scan;
  scan.header = header(kSecond);
  scan.angle_increment = 0.1f;
  scan.ranges = {1.0f, 2.0f};
  file.add("/scan", kSecond, scan);
  write("a.mcap", file.finish());
  const auto source = make(
      "{ topic: /odom, sensor: a }, { topic: /odom, sensor: b, payload: Height }, { topic: /twist, sensor: a },"
      " { topic: /scan, sensor: lidar }");
  const auto all = read_all(*source);
  ASSERT_THAT(all, SizeIs(4));
  EXPECT_EQ(all[0].as<LaserScan>().ranges_m, (std::vector<float>{1.0f, 2.0f}));
  EXPECT_EQ(all[1].as<BodyTwist>().v_x_mps, 1.5);
  EXPECT_EQ(all[1].stamp, at(2 * kSecond - 5));
  EXPECT_EQ(all[1].arrival, at(2 * kSecond));
  EXPECT_EQ(all[2].as<Height>().height_m, 0.25);
  EXPECT_EQ(all[2].as<Height>().sigma_m, 0.2);
  EXPECT_EQ(all[3].as<BodyTwist>().v_x_mps, 2.0);
  EXPECT_EQ(source->channels()[all[3].sensor].sensor, "a");
  EXPECT_EQ(source->progress(), 1.0);
}

TEST_F(McapSourceTest, CloudsHaveTheTimesOfTheirPoints) {
  TopicWriter file;
  file.add("/points", kSecond, ros_test::timed_cloud(header(kSecond), "t", ros_test::kUint32, {0, 1e8}));
  auto hostile = ros_test::timed_cloud(header(2 * kSecond), "t", ros_test::kUint32, {0, 1e8});
  hostile.width = 0xffff'ffff;
  file.add("/points", 2 * kSecond, hostile);
  write("a.mcap", file.finish());
  rig_ = Rig({{"lidar", "waymark/PointCloud@1", std::nullopt}});
  const auto source = make("{ topic: /points, sensor: lidar }", "file: a.mcap\nmax_bad_records: 1");
  const auto all = read_all(*source);
  ASSERT_THAT(all, SizeIs(1));
  const auto& cloud = all[0].as<PointCloud>();
  EXPECT_EQ(cloud.points_m, (std::vector<Eigen::Vector3f>{{0.0f, 0.0f, 0.0f}, {1.0f, 2.0f, 3.0f}}));
  EXPECT_EQ(cloud.intensities, (std::vector<float>{0.0f, 10.0f}));
  EXPECT_EQ(cloud.offsets_s, (std::vector<float>{0.0f, 0.1f}));
  EXPECT_THAT(source->bad_records().at(0).reason, HasSubstr("a cloud of 4294967295 x 1 points of 20 bytes"));
}

TEST_F(McapSourceTest, PosesBecomeIncrements) {
  TopicWriter file;
  for (std::int64_t k = 0; k < 4; ++k) file.add("/odom", (k + 1) * kSecond, odometry((k + 1) * kSecond, 0.5 * k, 0.0));
  write("a.mcap", file.finish());
  const auto all = read_all(*make("{ topic: /odom, sensor: a, payload: PoseIncrement }"));
  ASSERT_THAT(all, SizeIs(3));
  EXPECT_EQ(all[0].stamp, at(kSecond));
  EXPECT_EQ(all[0].arrival, at(2 * kSecond)) << "it arrives at the end of its interval";
  EXPECT_DOUBLE_EQ(all[0].as<PoseIncrement>().x_m, 0.5);
  const auto by_stamp =
      read_all(*make("{ topic: /odom, sensor: a, payload: PoseIncrement }", "file: a.mcap\narrival: stamp"));
  ASSERT_THAT(by_stamp, SizeIs(3));
  EXPECT_EQ(by_stamp[0].arrival, at(2 * kSecond));
}

TEST_F(McapSourceTest, DirtyStampsAreReplacedByTheTimeOfRecording) {
  TopicWriter file;
  file.add("/twist", 5 * kSecond, twist(0, 1.0));
  file.add("/twist", 6 * kSecond, twist(900 * kSecond, 2.0));
  write("a.mcap", file.finish());
  const auto recorded = read_all(*make("{ topic: /twist, sensor: a, stamp: recorded }"));
  ASSERT_THAT(recorded, SizeIs(2));
  EXPECT_EQ(recorded[1].stamp, at(6 * kSecond));
  const auto source = make("{ topic: /twist, sensor: a }", "file: a.mcap\nmax_bad_records: 2");
  EXPECT_THAT(read_all(*source), IsEmpty());
  EXPECT_THAT(source->bad_records()[0].reason, HasSubstr("its header has no stamp; `stamp: recorded`"));
  EXPECT_THAT(source->bad_records()[1].reason, HasSubstr("s after it was recorded"));
  EXPECT_THAT(source->bad_records()[0].place, HasSubstr("a.mcap:byte "));
}

TEST_F(McapSourceTest, ForeignTypesAreReadByTheirDefinition) {
  TopicWriter file;
  const std::string definition =
      "std_msgs/Header header\nfloat64[] covariance\ngeometry_msgs/Vector3 velocity\nuint8 quality\n" +
      std::string(80, '=') + "\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n" + std::string(80, '=') +
      "\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n" + std::string(80, '=') +
      "\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";
  for (int k = 0; k < 3; ++k) {
    ros::WireWriter out;
    ros::write(out, header(7 * kSecond + k));
    out.count(2);
    out.value(0.5);
    out.value(0.5);
    for (const double v : {1.0 + k, 2.0, k == 2 ? std::numeric_limits<double>::quiet_NaN() : 3.0}) out.value(v);
    out.value(std::uint8_t{9});
    file.add("/dvl", "dvl_msgs/msg/DVL", definition, 10 * kSecond, out.bytes());
  }
  write("a.mcap", file.finish());
  const std::string channel = "{ topic: /dvl, sensor: a, payload: BodyTwist, fields: { v_x_mps: velocity.x, ";
  const auto source =
      make(channel + "v_y_mps: -velocity.y, w_z_radps: velocity.z } }", "file: a.mcap\nmax_bad_records: 1");
  const auto all = read_all(*source);
  ASSERT_THAT(all, SizeIs(2));
  EXPECT_EQ(all[1].as<BodyTwist>().v_x_mps, 2.0);
  EXPECT_EQ(all[1].as<BodyTwist>().v_y_mps, -2.0);
  EXPECT_EQ(all[1].stamp, at(7 * kSecond + 1));
  EXPECT_THAT(source->bad_records(), SizeIs(1)) << "NaN reaches no filter";

  EXPECT_EQ(read_all(*make(channel + "w_z_radps: 0.25 } }"))[0].as<BodyTwist>().w_z_radps, 0.25);
  EXPECT_THAT(error_of(channel + "w_z_radps: velocity.zz } }"),
              AllOf(HasSubstr("the message has no number \"velocity.zz\"; did you mean \"velocity.z\"?"),
                    HasSubstr("quality")));
  EXPECT_THAT(error_of(channel + "w_z: 0 } }"), HasSubstr("BodyTwist has no number \"w_z\""));
  EXPECT_THAT(error_of("{ topic: /dvl, sensor: a, payload: BodyTwist, fields: { v_x_mps: velocity.x } }"),
              HasSubstr("w_z_radps is missing, which BodyTwist needs"));
  EXPECT_THAT(error_of("{ topic: /dvl, sensor: lidar, payload: LaserScan, fields: { start_rad: 0, step_rad: 1 } }"),
              HasSubstr("LaserScan cannot be made of numbers: it needs ranges_m"));
  EXPECT_THAT(error_of("{ topic: /dvl, sensor: a, fields: { v_x_mps: 1 } }"), HasSubstr("the payload is needed"));
  EXPECT_THAT(error_of("{ topic: /dvl, sensor: a }"),
              AllOf(HasSubstr("carries dvl_msgs/msg/DVL"), HasSubstr("`fields` reads numbers of others")));
}

TEST_F(McapSourceTest, ATimeOfRecordingBeyondAllStampsIsBad) {
  TopicWriter file;
  constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
  for (const std::int64_t recorded : {-kMost - 1, -kMost / 2 - 1, 8 * kSecond, kMost / 2 + 1, kMost})
    file.add("/twist", recorded, twist(7 * kSecond, 1.0));
  write("a.mcap", file.finish());
  for (const std::string arrival : {"recorded", "stamp"}) {
    const auto source = make("{ topic: /twist, sensor: a }", "file: a.mcap\nmax_bad_records: 10\narrival: " + arrival);
    EXPECT_THAT(read_all(*source), SizeIs(1)) << arrival;
    EXPECT_THAT(source->bad_records(), SizeIs(4)) << arrival;
  }
}

TEST_F(McapSourceTest, AStampOfARecordedDefinitionMustBeATime) {
  TopicWriter file;
  const std::string definition =
      "s/Header header\nfloat64 v\n===\nMSG: s/Header\ns/Time stamp\n===\nMSG: s/Time\n"
      "float64 sec\nfloat64 nanosec\n";
  const std::vector<std::pair<double, double>> stamps{
      {7.0, 1.0}, {1e300, 0.0}, {-1e10, 0.0}, {4294967296.0, 0.0}, {7.0, -1.0}, {7.0, 1e9}, {7.0, std::nan("")}};
  for (const auto& [seconds, nanoseconds] : stamps) {
    ros::WireWriter out;
    for (const double number : {seconds, nanoseconds, 0.5}) out.value(number);
    file.add("/v", "s/msg/V", definition, 10 * kSecond, out.bytes());
  }
  write("a.mcap", file.finish());
  const auto source = make("{ topic: /v, sensor: a, payload: BodyTwist, fields: { v_x_mps: v, w_z_radps: 0 } }",
                           "file: a.mcap\nmax_bad_records: 10");
  EXPECT_THAT(read_all(*source), SizeIs(1));
  EXPECT_THAT(source->bad_records(), SizeIs(6));
}

TEST_F(McapSourceTest, ATypeWithAnotherDefinitionIsRefused) {
  TopicWriter file;
  file.add("/twist", "geometry_msgs/msg/TwistStamped", "float64 v\n", kSecond, {0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
  write("a.mcap", file.finish());
  EXPECT_THAT(error_of("{ topic: /twist, sensor: a }"),
              HasSubstr("whose definition is another one: its fields are f8"));
}

TEST_F(McapSourceTest, ErrorsNameWhatThereIs) {
  TopicWriter file;
  file.add("/twist", kSecond, twist(kSecond, 1.0));
  write("a.mcap", file.finish());
  EXPECT_THAT(error_of("{ topic: /twits, sensor: a }"),
              AllOf(HasSubstr("did you mean \"/twist\"?"), HasSubstr("topics in the file"),
                    HasSubstr("/twist (geometry_msgs/msg/TwistStamped, 1)")));
  EXPECT_THAT(error_of("{ topic: /twist, sensor: lidar }"), HasSubstr("takes waymark/LaserScan@1"));
  EXPECT_THAT(error_of("{ topic: /twist, sensor: a }", "file: none.mcap"), HasSubstr("none.mcap: cannot be read"));
  write("b.mcap", {'n', 'o'});
  EXPECT_THAT(error_of("{ topic: /twist, sensor: a }", "file: b.mcap"), HasSubstr("b.mcap:byte 0: begins with \"no\""));
}

TEST_F(McapSourceTest, ACutOffFileIsReadUpToTheCut) {
  mcap::WriterOptions options;
  options.chunk_size = 500;
  TopicWriter file(options);
  for (int k = 1; k <= 50; ++k) file.add("/twist", k * kSecond, twist(k * kSecond, k));
  auto bytes = file.finish();
  bytes.resize(bytes.size() / 2);
  write("a.mcap", bytes);
  const auto source = make("{ topic: /twist, sensor: a }", "file: a.mcap\nmax_bad_records: 1");
  const auto all = read_all(*source);
  EXPECT_GT(all.size(), 10U);
  ASSERT_THAT(source->bad_records(), SizeIs(1));
  EXPECT_THAT(source->bad_records()[0].reason, HasSubstr("the file ends early"));
  EXPECT_THAT(error_of<DataError>("{ topic: /twist, sensor: a }"), HasSubstr("max_bad_records allows 0"));
}

TEST_F(McapSourceTest, SeveralFilesAreReadAsOne) {
  for (int part = 0; part < 2; ++part) {
    TopicWriter file;
    for (int k = 1; k <= 5; ++k) file.add("/twist", (2 * k + part) * kSecond, twist((2 * k + part) * kSecond, k));
    write(part == 0 ? "a.mcap" : "b.mcap", file.finish());
  }
  const auto all = read_all(*make("{ topic: /twist, sensor: a }", "file: [a.mcap, b.mcap]"));
  ASSERT_THAT(all, SizeIs(10));
  EXPECT_EQ(all[1].arrival, at(3 * kSecond));
}

TEST_F(McapSourceTest, OwnPayloadsAreRead) {
  mcap::Writer writer({});
  const std::string definition = ros::payload_definition(Height::kType);
  writer.add(
      mcap::Schema{1, ros::payload_message_type(Height::kType), "ros2msg", {definition.begin(), definition.end()}});
  writer.add(mcap::Channel{1, 1, "/height", "cdr", {{std::string(mcap::kPayloadKey), std::string(Height::kType)}}});
  Height height;
  height.height_m = 3.0;
  const auto content = ros::payload_to_cdr(height);
  writer.add(mcap::Message{1, 0, 20, 10, content});
  writer.finish();
  write("a.mcap", writer.take());
  const auto all = read_all(*make("{ topic: /height, sensor: a }"));
  ASSERT_THAT(all, SizeIs(1));
  EXPECT_EQ(all[0].stamp, at(10));
  EXPECT_EQ(all[0].as<Height>().height_m, 3.0);
}

TEST_F(McapSourceTest, WithoutChannelsAFlightRecordIsExpected) {
  TopicWriter file;
  file.add("/twist", kSecond, twist(kSecond, 1.0));
  write("a.mcap", file.finish());
  EXPECT_THROW(
      {
        try {
          make_of("file: a.mcap");
        } catch (const ConfigError& error) {
          EXPECT_THAT(error.what(), HasSubstr("it is not a flight record"));
          throw;
        }
      },
      ConfigError);
}

}  // namespace
}  // namespace waymark::mcap_test
