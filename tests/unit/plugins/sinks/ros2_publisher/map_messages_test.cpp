// SPDX-License-Identifier: Apache-2.0
#include "map_messages.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "diagnostics_message.hpp"
#include "measurement_topics.hpp"
#include "plugins/shared/cdr/message.hpp"
#include "plugins/shared/map_formats/octree_bytes.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::ros2_publisher {
namespace {

using ::testing::ElementsAre;

const Time kNow{from_seconds(5.0)};

GridView grid(std::vector<std::uint8_t> cells) {
  return {Pose::planar(-1.0, 2.0, 0.0), 0.5, 3, static_cast<int>(cells.size()) / 3, std::move(cells)};
}

TEST(GridMessage, HasPercentsAndMinusOneForUnknown) {
  const auto message = grid_message(grid({0, 50, 100, GridView::kUnknown, 1, 2}), kNow, "map");
  EXPECT_THAT(message.data, ElementsAre(0, 50, 100, -1, 1, 2));
  EXPECT_EQ(message.info.width, 3U);
  EXPECT_EQ(message.info.height, 2U);
  EXPECT_EQ(message.info.resolution, 0.5f);
  EXPECT_EQ(message.info.origin.position.x, -1.0);
}

TEST(GridUpdate, IsTheRectangleThatDiffersFromTheWholeGridThatWasSent) {
  const GridView full = grid({0, 0, 0, 0, 0, 0, 0, 0, 0});
  const auto update = grid_update(full, grid({0, 0, 0, 0, 9, 8, 0, 0, 7}), kNow, "map");
  ASSERT_TRUE(update);
  EXPECT_EQ(update->x, 1);
  EXPECT_EQ(update->y, 1);
  EXPECT_EQ(update->width, 2U);
  EXPECT_EQ(update->height, 2U);
  EXPECT_THAT(update->data, ElementsAre(9, 8, 0, 7));
  EXPECT_FALSE(grid_update(full, full, kNow, "map"));
  EXPECT_FALSE(grid_update(full, grid({1, 0, 0}), kNow, "map")) << "of another size";
}

MapDescription landmarks(std::initializer_list<std::int64_t> ids) {
  MapDescription map;
  map.module = "pillars";
  for (const std::int64_t id : ids) {
    LandmarkView landmark;
    landmark.id = id;
    landmark.p_map = {1.0, 2.0};
    landmark.radius_m = 0.25;
    landmark.P.diagonal() << 0.01, 0.04, 0.0;
    landmark.confirmed = true;
    map.landmarks.push_back(landmark);
  }
  return map;
}

TEST(LandmarkMarkers, AreCylindersWithEllipsesOf95Percent) {
  LandmarkMarkers markers;
  const auto message = markers.message({landmarks({7})}, kNow, "map");
  ASSERT_EQ(message.markers.size(), 3U);
  EXPECT_EQ(message.markers[0].ns, "pillars");
  EXPECT_EQ(message.markers[0].id, 7);
  EXPECT_EQ(message.markers[0].scale.x, 0.5);
  const auto& ellipse = message.markers[1];
  EXPECT_NEAR(ellipse.scale.x, 2.0 * 0.2 * std::sqrt(5.991), 1e-9) << "the longer axis";
  EXPECT_NEAR(ellipse.scale.y, 2.0 * 0.1 * std::sqrt(5.991), 1e-9);
  EXPECT_NEAR(std::abs(ellipse.pose.orientation.z), std::sqrt(0.5), 1e-9) << "it points north";
  EXPECT_EQ(message.markers[2].text, "7");
}

TEST(LandmarkMarkers, OfALandmarkThatHasGoneAreDeletedOnce) {
  LandmarkMarkers markers;
  markers.message({landmarks({7, 8})}, kNow, "map");
  const auto second = markers.message({landmarks({8})}, kNow, "map");
  ASSERT_EQ(second.markers.size(), 6U);
  for (std::size_t i = 3; i < 6; ++i) {
    EXPECT_EQ(second.markers[i].action, 2);
    EXPECT_EQ(second.markers[i].id, 7);
  }
  EXPECT_EQ(markers.message({landmarks({8})}, kNow, "map").markers.size(), 3U);
}

TEST(PathMessage, IsThinnedAndKeepsTheLastPose) {
  std::vector<StampedPose> path;
  for (int k = 0; k < 101; ++k) path.push_back({Time{from_seconds(k)}, Pose::planar(k, 0.0, 0.0)});
  const auto message = path_message(path, 10, kNow, "map");
  EXPECT_LE(message.poses.size(), 10U);
  EXPECT_EQ(message.poses.back().pose.position.x, 100.0);
  EXPECT_LT(message.poses.front().pose.position.x, 15.0);
  EXPECT_EQ(path_message(path, 1000, kNow, "map").poses.size(), 101U);
  EXPECT_TRUE(path_message({}, 10, kNow, "map").poses.empty());
}

TEST(OctomapMessage, HasWhatFollowsTheHeaderOfTheFile) {
  const std::string nodes("\x01\x02\x03\x04", 4);
  const auto message = octomap_message({".bt", map_formats::octree_header(true, 2, 0.1) + nodes}, kNow, "map");
  ASSERT_TRUE(message);
  EXPECT_TRUE(message->binary);
  EXPECT_EQ(message->id, "OcTree");
  EXPECT_EQ(message->resolution, 0.1);
  EXPECT_THAT(message->data, ElementsAre(1, 2, 3, 4));
  EXPECT_FALSE(octomap_message({".pgm", "P5"}, kNow, "map"));
  EXPECT_FALSE(octomap_message({".bt", "rubbish"}, kNow, "map"));
}

TEST(DiagnosticsMessage, HasAStatusOfThePoseAndOfEverySensor) {
  Health health;
  health.state = Health::State::degraded;
  health.reason = "gps is silent";
  health.sensors = {{}, {SensorHealth::State::silent, "no fix for 3 s"}};
  const auto message = diagnostics_message(health, {"wheels", "gps"}, kNow);
  ASSERT_EQ(message.status.size(), 3U);
  EXPECT_EQ(message.status[0].level, std::byte{1});
  EXPECT_EQ(message.status[0].message, "degraded: gps is silent");
  EXPECT_EQ(message.status[1].level, std::byte{0});
  EXPECT_EQ(message.status[2].name, "waymark: gps");
  EXPECT_EQ(message.status[2].level, std::byte{3});
}

// --- measurements ----------------------------------------------------------------------------------------------------

TEST(MeasurementMessage, EveryPayloadHasATypeAndThoseWithoutOneOfRosAreWaymarksOwn) {
  const MeasurementSettings settings;
  const ros::std_msgs::Header header;
  const auto type_of = [&](const Payload& payload) { return message_of(payload, header, settings, {}).type; };
  EXPECT_EQ(type_of(ImuSample()), "sensor_msgs/msg/Imu");
  EXPECT_EQ(type_of(MagneticField()), "sensor_msgs/msg/MagneticField");
  EXPECT_EQ(type_of(WheelSpeeds()), "sensor_msgs/msg/JointState");
  EXPECT_EQ(type_of(BodyTwist()), "geometry_msgs/msg/TwistStamped");
  EXPECT_EQ(type_of(LaserScan()), "sensor_msgs/msg/LaserScan");
  EXPECT_EQ(type_of(PointCloud()), "sensor_msgs/msg/PointCloud2");
  EXPECT_EQ(type_of(Image()), "sensor_msgs/msg/Image");
  EXPECT_EQ(type_of(WheelSteering()), "waymark_msgs/msg/WheelSteering");
  EXPECT_EQ(type_of(LandmarkObservations()), "waymark_msgs/msg/LandmarkObservations");
  Image picture;
  picture.encoding = Image::Encoding::compressed;
  EXPECT_EQ(type_of(picture), "sensor_msgs/msg/CompressedImage");
}

TEST(MeasurementMessage, AFixInTheMapIsOneOnTheEarthIfTheDatumIsKnown) {
  GnssFix fix;
  fix.p_map_antenna = {0.0, 111.2, 3.0};
  fix.type = GnssFix::Type::single;
  const MeasurementSettings settings;
  EXPECT_EQ(message_of(fix, {}, settings, {}).type, "waymark_msgs/msg/GnssFix");
  const TypedMessage message = message_of(fix, {}, settings, Datum{49.0, 8.0, 100.0});
  ASSERT_EQ(message.type, "sensor_msgs/msg/NavSatFix");
  const auto decoded = ros::from_cdr<ros::sensor_msgs::NavSatFix>(message.cdr);
  EXPECT_NEAR(decoded.latitude, 49.001, 1e-6);
  EXPECT_NEAR(decoded.altitude, 103.0, 0.01);
}

TEST(CameraInfo, IsTheModelOfOpenCv) {
  const auto info = camera_info({640, 480, 500.0, 501.0, 320.0, 240.0, {0.1, 0.2, 0.3, 0.4, 0.5}}, {});
  EXPECT_EQ(info.distortion_model, "plumb_bob");
  EXPECT_THAT(info.d, ElementsAre(0.1, 0.2, 0.3, 0.4, 0.5));
  EXPECT_THAT(info.k, ElementsAre(500.0, 0.0, 320.0, 0.0, 501.0, 240.0, 0.0, 0.0, 1.0));
  EXPECT_EQ(info.p[5], 501.0);
}

}  // namespace
}  // namespace waymark::ros2_publisher
