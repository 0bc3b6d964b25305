// SPDX-License-Identifier: Apache-2.0
// The sink ros2_publisher with readers in the same process.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <atomic>
#include <thread>

#include "dds_domain.hpp"
#include "live_source.hpp"
#include "plugins/shared/cdr/message.hpp"
#include "plugins/shared/cdr/ros/diagnostic_msgs.hpp"
#include "plugins/shared/cdr/ros/nav_msgs.hpp"
#include "plugins/shared/cdr/ros/sensor_msgs.hpp"
#include "plugins/shared/cdr/ros/visualization_msgs.hpp"
#include "plugins/shared/dds/reader.hpp"
#include "publisher.hpp"
#include "unit/plugins/sinks/fake_snapshot.hpp"
#include "waymark/base/error.hpp"

namespace waymark {
namespace {

using test::eventually;
using test::FakeSnapshot;
using test::TemporaryFolder;
using ::testing::HasSubstr;

constexpr dds::Quality kReliable{.reliable = true, .latched = false, .depth = 100};
constexpr dds::Quality kLatched{.reliable = true, .latched = true, .depth = 1};
constexpr const char* kDatum = "datum: { latitude_deg: 49, longitude_deg: 8 }";

Rig rig() {
  return Rig({{"wheels", std::string(WheelSpeeds::kType), {}},
              {"lidar", std::string(LaserScan::kType), Pose::planar(0.2, 0.0, 0.0)},
              {"camera", std::string(Image::kType), Pose{}, Intrinsics{2, 1, 500.0, 500.0, 1.0, 0.5}}});
}

template <ros::Message M>
class Topic {
 public:
  Topic(const dds::Participant& participant, const std::string& name, const dds::Quality& quality = kReliable)
      : reader_(participant, name, std::string(M::kType), quality) {}
  bool wait_for_writer() const {
    return eventually([this] { return reader_.writers() > 0; });
  }
  /// All messages so far, once there are so many.
  const std::vector<M>& wait_for(std::size_t count) {
    eventually([&] {
      std::vector<dds::Sample> samples;
      reader_.take(samples);
      for (const dds::Sample& sample : samples) messages_.push_back(ros::from_cdr<M>(sample.bytes()));
      return messages_.size() >= count;
    });
    return messages_;
  }

 private:
  dds::Reader reader_;
  std::vector<M> messages_;
};

class Ros2Publisher : public ::testing::Test {
 protected:
  std::shared_ptr<Sink> start(const std::string& keys, const std::string& config = "") {
    const std::string yaml = fmt::format("{{ domain: {}{}{} }}", test::own_domain(), keys.empty() ? "" : ", ", keys);
    auto sink =
        PluginLoader({WAYMARK_PLUGIN_DIR}).create<Sink>("ros2_publisher", Config::parse(yaml, "robot.yaml"), rig());
    sink->start({out_.path(), nullptr, nullptr, config});
    return sink;
  }

  TemporaryFolder out_;
  dds::Participant robot_{{test::own_domain(), "lo"}};
  FakeSnapshot snapshot_;
};

TEST_F(Ros2Publisher, ThePoseNowIsOdometryAndTransforms) {
  const auto sink = start("");
  Topic<ros::nav_msgs::Odometry> smooth(robot_, "/odometry/filtered");
  Topic<ros::nav_msgs::Odometry> in_map(robot_, "/odometry/filtered_map");
  Topic<ros::tf2_msgs::TFMessage> tf(robot_, "/tf");
  Topic<ros::geometry_msgs::PoseWithCovarianceStamped> pose(robot_, "/pose");
  ASSERT_TRUE(smooth.wait_for_writer() && in_map.wait_for_writer() && tf.wait_for_writer() && pose.wait_for_writer());
  snapshot_.at(1.0, Pose::planar(3.0, 4.0, 0.0));
  sink->front(snapshot_.belief_);  // before the filter has started: nothing
  sink->write(snapshot_);
  sink->front(snapshot_.belief_);
  sink->front(snapshot_.belief_);  // no later: /tf takes a stamp once
  snapshot_.at(2.0, Pose::planar(5.0, 4.0, 0.0));
  sink->front(snapshot_.belief_);
  ASSERT_EQ(in_map.wait_for(2).size(), 2U);
  EXPECT_EQ(in_map.wait_for(2)[1].pose.pose.position.x, 5.0);
  ASSERT_EQ(smooth.wait_for(2).size(), 2U);
  EXPECT_EQ(smooth.wait_for(2)[1].pose.pose.position.x, 0.0) << "a jump of the pose is none of odom";
  EXPECT_EQ(smooth.wait_for(2)[1].header.frame_id, "odom");
  EXPECT_EQ(tf.wait_for(2).size(), 2U);
  EXPECT_EQ(pose.wait_for(2).size(), 2U);
  snapshot_.started_ = false;  // the pose is lost
  sink->write(snapshot_);
  snapshot_.belief_.stamp += from_seconds(1.0);
  sink->front(snapshot_.belief_);
  EXPECT_EQ(in_map.wait_for(2).size(), 2U);
  sink->finish(&snapshot_, {});
}

TEST_F(Ros2Publisher, OfALogThePoseFollowsEveryMeasurementAndTheFixNeedsTheDatum) {
  const auto sink = start("when: committed, publish: [fix], topics: { fix: /here }", kDatum);
  Topic<ros::sensor_msgs::NavSatFix> fix(robot_, "/here");
  ASSERT_TRUE(fix.wait_for_writer());
  snapshot_.at(1.0, Pose::planar(0.0, 0.0, 0.0));
  sink->write(snapshot_);
  ASSERT_EQ(fix.wait_for(1).size(), 1U);
  EXPECT_NEAR(fix.wait_for(1)[0].latitude, 49.0, 1e-9);
  EXPECT_THROW(start("publish: [fix]"), Error);
}

TEST_F(Ros2Publisher, WhoComesLaterGetsTheMapAndEveryUpdateCompletesIt) {
  const auto sink = start("publish: [map, landmarks, diagnostics], period_s: 1, full_period_s: 100");
  MapDescription map;
  map.module = "floor";
  map.grid = GridView{Pose{}, 0.1, 2, 1, {0, 100}};
  snapshot_.maps_ = {map};
  snapshot_.at(1.0, Pose{});
  sink->write(snapshot_);
  Topic<ros::nav_msgs::OccupancyGrid> whole(robot_, "/map", kLatched);
  Topic<ros::map_msgs::OccupancyGridUpdate> updates(robot_, "/map_updates");
  Topic<ros::visualization_msgs::MarkerArray> landmarks(robot_, "/landmarks", kLatched);
  Topic<ros::diagnostic_msgs::DiagnosticArray> diagnostics(robot_, "/diagnostics");
  ASSERT_TRUE(updates.wait_for_writer() && landmarks.wait_for_writer() && diagnostics.wait_for_writer());
  ASSERT_EQ(whole.wait_for(1).size(), 1U);
  EXPECT_EQ(whole.wait_for(1)[0].data, (std::vector<std::int8_t>{0, 100}));
  snapshot_.maps_[0].grid->cells = {0, 50};
  snapshot_.at(1.5, Pose{});
  sink->write(snapshot_);  // not yet due
  snapshot_.at(2.5, Pose{});
  sink->write(snapshot_);
  ASSERT_EQ(updates.wait_for(1).size(), 1U);
  EXPECT_EQ(updates.wait_for(1)[0].x, 1);
  EXPECT_EQ(updates.wait_for(1)[0].data, (std::vector<std::int8_t>{50}));
  EXPECT_EQ(landmarks.wait_for(1).size(), 1U);
  EXPECT_EQ(diagnostics.wait_for(1).size(), 1U);
  EXPECT_EQ(whole.wait_for(1).size(), 1U);
}

Measurement measurement(std::uint32_t sensor, double seconds, std::shared_ptr<Payload> payload) {
  Measurement m;
  m.stamp = m.arrival = Time{from_seconds(seconds)};
  m.sensor = sensor;
  m.payload = std::move(payload);
  return m;
}

TEST_F(Ros2Publisher, MeasurementsAreTheTopicsOfTheRobot) {
  const auto sink =
      start("publish: [measurements], measurements: { topics: { lidar: /scan, camera: /eye/image_raw } }");
  Topic<ros::sensor_msgs::LaserScan> scan(robot_, "/scan");
  Topic<ros::sensor_msgs::JointState> wheels(robot_, "/wheels");
  Topic<ros::sensor_msgs::CameraInfo> info(robot_, "/eye/camera_info");
  Topic<ros::tf2_msgs::TFMessage> tf(robot_, "/tf_static", kLatched);
  ASSERT_EQ(tf.wait_for(1).size(), 1U);
  ASSERT_EQ(tf.wait_for(1)[0].transforms.size(), 2U);
  EXPECT_EQ(tf.wait_for(1)[0].transforms[0].child_frame_id, "lidar");
  EXPECT_EQ(tf.wait_for(1)[0].transforms[1].child_frame_id, "camera_optical");
  auto beams = std::make_shared<LaserScan>();
  beams->step_rad = 0.1;
  beams->ranges_m = {1.0f, 2.0f};
  auto speeds = std::make_shared<WheelSpeeds>();
  speeds->left_mps = 0.1;
  auto picture = std::make_shared<Image>();
  picture->width = 2;
  picture->height = 1;
  picture->data.assign(6, 0);
  // The writers are made with the first measurements: those are for whoever is there.
  ASSERT_TRUE(eventually([&] {
    sink->arrived(measurement(0, 1.0, speeds));
    sink->arrived(measurement(1, 1.0, beams));
    sink->arrived(measurement(2, 1.0, picture));
    return !scan.wait_for(0).empty() && !wheels.wait_for(0).empty() && !info.wait_for(0).empty();
  }));
  EXPECT_EQ(scan.wait_for(1)[0].header.frame_id, "lidar");
  EXPECT_EQ(scan.wait_for(1)[0].ranges, (std::vector<float>{1.0f, 2.0f}));
  EXPECT_EQ(wheels.wait_for(1)[0].velocity, (std::vector<double>{0.1, 0.0}));
  EXPECT_EQ(info.wait_for(1)[0].k[0], 500.0);
  sink->finish(nullptr, {});
}

TEST_F(Ros2Publisher, PosesAndMapsComeFromTwoThreads) {
  const auto sink = start("period_s: 0.05");
  Topic<ros::tf2_msgs::TFMessage> tf(robot_, "/tf");
  ASSERT_TRUE(tf.wait_for_writer());
  std::atomic<bool> ends = false;
  snapshot_.at(0.0, Pose{});
  sink->write(snapshot_);
  std::thread outputs([&] {
    Belief belief = snapshot_.belief_;
    while (!ends) {
      belief.stamp += std::chrono::milliseconds(1);
      sink->front(belief);
    }
  });
  FakeSnapshot filter;
  for (int k = 0; k < 200; ++k) {
    filter.at(0.05 * k, Pose{});
    sink->write(filter);
  }
  EXPECT_FALSE(tf.wait_for(1).empty());
  sink->finish(&filter, {});
  ends = true;
  outputs.join();
}

TEST(Ros2PublisherQueue, LeavesOutTheOldestIfTooMuchWaits) {
  const dds::Participant robot({test::own_domain(), "lo"});
  dds::Writer writer(robot, "/a", "std_msgs/msg/Header", {}, std::chrono::milliseconds(0));
  ros2_publisher::Publisher publisher(100);
  for (int k = 0; k < 1000; ++k) publisher.send(writer, std::vector<std::uint8_t>(64, 0));
  EXPECT_GT(publisher.left_out(), 0U);
  publisher.finish(std::chrono::seconds(1));
}

TEST_F(Ros2Publisher, RefusesUnknownWordsSensorsAndTopics) {
  const auto error_of = [&](const std::string& keys) {
    try {
      start(keys);
      return std::string("none");
    } catch (const ConfigError& error) {
      return std::string(error.what());
    }
  };
  EXPECT_THAT(error_of("publish: [maps]"), HasSubstr("did you mean \"map\"?"));
  EXPECT_THAT(error_of("measurements: { topics: { lidr: /scan } }"), HasSubstr("did you mean \"lidar\"?"));
  EXPECT_THAT(error_of("topics: { map: \"a b\" }"), HasSubstr("is no topic of ROS"));
}

}  // namespace
}  // namespace waymark
