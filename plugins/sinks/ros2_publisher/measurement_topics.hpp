// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "plugins/shared/cdr/conversions.hpp"
#include "plugins/shared/dds/participant.hpp"
#include "plugins/shared/live/event_list.hpp"
#include "pose_messages.hpp"
#include "publisher.hpp"
#include "waymark/config/config.hpp"
#include "waymark/interface/measurement.hpp"
#include "waymark/interface/rig.hpp"

namespace waymark::ros2_publisher {

/// A message with the type that it is published as.
struct TypedMessage {
  std::string type;  ///< "sensor_msgs/msg/Imu"
  std::vector<std::uint8_t> cdr;
};

/// How payloads become messages.
struct MeasurementSettings {
  std::map<std::string, std::string> topics;  ///< by sensor; of others "/" and the name
  ros::WheelJoints wheels{{"left_wheel"}, {"right_wheel"}, 1.0};
  float range_min_m = 0.0f;  ///< of LaserScan
  float range_max_m = 0.0f;
  bool is_reliable = true;
};

/// Reads the block `measurements`. Throws ConfigError.
MeasurementSettings read_measurement_settings(const Config& config, const Rig& rig);

/// A payload as the message of ROS that has its content; a payload that ROS has no message for as waymark's own. Fixes
/// in the map need `datum`. Throws Unusable for a payload that registers no fields.
TypedMessage message_of(const Payload& payload, const ros::std_msgs::Header& header,
                        const MeasurementSettings& settings, const std::optional<Datum>& datum);

/// Where the picture of a camera is: z forward, x right, y down.
ros::sensor_msgs::CameraInfo camera_info(const Intrinsics& intrinsics, ros::std_msgs::Header header);

/// Publishes what a source delivers, as the robot itself would: a topic per sensor, camera_info beside pictures, and
/// /tf_static.
class MeasurementTopics {
 public:
  /// Publishes /tf_static. All arguments but `settings` and `datum` must outlive the object. Throws Error.
  MeasurementTopics(const dds::Participant& participant, Publisher& publisher, live::EventList& events, const Rig& rig,
                    MeasurementSettings settings, std::optional<Datum> datum, const std::string& base_frame);

  void publish(const Measurement& measurement);
  void wait_for_readers(std::chrono::milliseconds limit);
  std::uint64_t left_out() const;

 private:
  struct Topic {
    std::string name;
    std::unique_ptr<dds::Writer> writer;
  };
  std::string frame_of(std::size_t sensor) const;
  Topic& topic_of(std::size_t sensor, const std::string& type);
  void publish_mountings(const std::string& base_frame);
  void publish_camera_info(std::size_t sensor, const ros::std_msgs::Header& header);
  void leave_out(std::string_view sensor, std::string_view why);

  const dds::Participant& participant_;
  Publisher& publisher_;
  live::EventList& events_;
  const Rig& rig_;
  MeasurementSettings settings_;
  std::optional<Datum> datum_;
  std::map<std::pair<std::size_t, std::string>, Topic> topics_;  // by sensor and type
  std::map<std::string, bool> is_left_out_;                      // reported
  std::unique_ptr<dds::Writer> tf_static_;
};

}  // namespace waymark::ros2_publisher
