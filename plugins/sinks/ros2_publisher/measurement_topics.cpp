// SPDX-License-Identifier: Apache-2.0
#include "measurement_topics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "plugins/shared/cdr/message.hpp"
#include "plugins/shared/cdr/message_kinds.hpp"
#include "plugins/shared/cdr/payload_cdr.hpp"
#include "plugins/shared/cdr/to_ros.hpp"
#include "plugins/shared/dds/names.hpp"
#include "waymark/config/nearest_name.hpp"

namespace waymark::ros2_publisher {
namespace {

constexpr dds::Quality kStaticTransforms{.reliable = true, .latched = true, .depth = 1};
constexpr std::chrono::milliseconds kPatienceOfSensors{500};

/// From x forward, y left, z up to z forward, x right, y down (REP 103).
Pose T_body_optical() {
  Eigen::Matrix3d R;
  R << 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0;
  return {Eigen::Quaterniond(R), Eigen::Vector3d::Zero()};
}

bool is_camera(const Mounting& mounting) { return mounting.intrinsics || mounting.payload == Image::kType; }

template <ros::Message M>
TypedMessage typed(const M& message) {
  return {std::string(M::kType), ros::to_cdr(message)};
}

template <class T>
const T* as(const Payload& payload) {
  return payload.type() == T::kType ? static_cast<const T*>(&payload) : nullptr;
}

/// A fix in the map as one on the Earth.
GnssFix with_place_on_earth(const GnssFix& fix, const std::optional<Datum>& datum) {
  GnssFix geodetic = fix;
  const bool is_local = fix.p_map_antenna.head<2>().allFinite() && !std::isfinite(fix.latitude_deg);
  if (!is_local || !datum) return geodetic;
  Eigen::Vector3d p = fix.p_map_antenna;
  if (!std::isfinite(p.z())) p.z() = 0.0;
  const Eigen::Vector3d place = on_earth(p, *datum);
  geodetic.latitude_deg = place.x();
  geodetic.longitude_deg = place.y();
  geodetic.height_m = place.z();
  return geodetic;
}

/// A word of a topic's name.
std::string word_of(const std::string& sensor) {
  std::string word = sensor;
  std::ranges::replace_if(
      word,
      [](char c) { return !((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_'); },
      '_');
  if (word.front() >= '0' && word.front() <= '9') word.insert(word.begin(), '_');
  return word;
}

}  // namespace

MeasurementSettings read_measurement_settings(const Config& config, const Rig& rig) {
  MeasurementSettings settings;
  const Config block = config.child_or_empty({"measurements", "of `publish: [measurements]`"});
  const Config topics =
      block.child_or_empty({"topics", "", "topic of each sensor: `lidar: /scan`", "`/` and its name"});
  std::vector<std::string> names;
  for (const Mounting& mounting : rig.mountings()) names.push_back(mounting.name);
  for (const std::string& sensor : topics.keys()) {
    const std::string topic = topics.text(sensor);
    try {
      dds::topic_name(topic);
    } catch (const std::invalid_argument& error) {
      topics.fail(sensor, error.what());
    }
    if (rig.find(sensor) < 0) {
      const std::string nearest = nearest_name(sensor, names);
      topics.fail(sensor, fmt::format("there is no sensor \"{}\"{}", sensor,
                                      nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest)));
    }
    settings.topics[sensor] = topic;
  }
  settings.is_reliable =
      block.boolean({"reliable", "false: what is lost on its way is not sent again (best effort)"}, true);
  const ros::WheelJoints wheels = ros::read_decoder_settings(block).wheels;
  if (!wheels.left.empty()) settings.wheels.left = wheels.left;
  if (!wheels.right.empty()) settings.wheels.right = wheels.right;
  if (wheels.radius_m > 0.0) settings.wheels.radius_m = wheels.radius_m;
  settings.range_min_m = static_cast<float>(
      block.non_negative({"range_min_m", "m", "`range_min` of scans, which payloads do not have"}, 0.0));
  settings.range_max_m =
      static_cast<float>(block.positive({"range_max_m", "m", "`range_max` of scans, likewise"}, 100.0));
  return settings;
}

TypedMessage message_of(const Payload& payload, const ros::std_msgs::Header& header,
                        const MeasurementSettings& settings, const std::optional<Datum>& datum) {
  if (const auto* imu = as<ImuSample>(payload)) return typed(ros::to_ros(*imu, header));
  if (const auto* field = as<MagneticField>(payload)) return typed(ros::to_ros(*field, header));
  if (const auto* cloud = as<PointCloud>(payload)) return typed(ros::to_ros(*cloud, header));
  if (const auto* twist = as<BodyTwist>(payload)) return typed(ros::to_ros(*twist, header));
  if (const auto* speeds = as<WheelSpeeds>(payload)) return typed(ros::to_ros(*speeds, header, settings.wheels));
  if (const auto* scan = as<LaserScan>(payload))
    return typed(ros::to_ros(*scan, header, settings.range_min_m, settings.range_max_m));
  if (const auto* image = as<Image>(payload)) {
    return image->encoding == Image::Encoding::compressed ? typed(ros::to_ros_compressed(*image, header))
                                                          : typed(ros::to_ros(*image, header));
  }
  if (const auto* fix = as<GnssFix>(payload)) {
    const GnssFix geodetic = with_place_on_earth(*fix, datum);
    const bool is_nowhere = !std::isfinite(geodetic.latitude_deg) && geodetic.type == GnssFix::Type::none;
    if (std::isfinite(geodetic.latitude_deg) || is_nowhere) return typed(ros::to_ros(geodetic, header));
  }
  return {ros::payload_message_type(payload.type()), ros::payload_to_cdr(payload)};
}

ros::sensor_msgs::CameraInfo camera_info(const Intrinsics& camera, ros::std_msgs::Header header) {
  ros::sensor_msgs::CameraInfo info;
  info.header = std::move(header);
  info.width = static_cast<std::uint32_t>(camera.width);
  info.height = static_cast<std::uint32_t>(camera.height);
  info.distortion_model = "plumb_bob";
  info.d.assign(camera.distortion.begin(), camera.distortion.end());
  info.k = {camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0};
  info.r = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
  info.p = {camera.fx, 0.0, camera.cx, 0.0, 0.0, camera.fy, camera.cy, 0.0, 0.0, 0.0, 1.0, 0.0};
  return info;
}

MeasurementTopics::MeasurementTopics(const dds::Participant& participant, Publisher& publisher, live::EventList& events,
                                     const Rig& rig, MeasurementSettings settings, std::optional<Datum> datum,
                                     const std::string& base_frame)
    : participant_(participant),
      publisher_(publisher),
      events_(events),
      rig_(rig),
      settings_(std::move(settings)),
      datum_(datum) {
  publish_mountings(base_frame);
}

void MeasurementTopics::publish_mountings(const std::string& base_frame) {
  ros::tf2_msgs::TFMessage message;
  for (std::size_t i = 0; i < rig_.mountings().size(); ++i) {
    const Mounting& mounting = rig_.mountings()[i];
    if (!mounting.T_base_sensor) continue;
    const Pose& T_base_body = *mounting.T_base_sensor;
    // Valid at all times.
    message.transforms.push_back(
        to_ros(is_camera(mounting) ? T_base_body * T_body_optical() : T_base_body, Time{}, base_frame, frame_of(i)));
  }
  tf_static_ = std::make_unique<dds::Writer>(participant_, "/tf_static", std::string(ros::tf2_msgs::TFMessage::kType),
                                             kStaticTransforms, kPatienceOfSensors);
  tf_static_->write(ros::to_cdr(message));
}

std::string MeasurementTopics::frame_of(std::size_t sensor) const {
  const Mounting& mounting = rig_.mountings().at(sensor);
  return is_camera(mounting) ? mounting.name + "_optical" : mounting.name;
}

MeasurementTopics::Topic& MeasurementTopics::topic_of(std::size_t sensor, const std::string& type) {
  const auto known = topics_.find({sensor, type});
  if (known != topics_.end()) return known->second;
  const std::string& name = rig_.mountings().at(sensor).name;
  const auto given = settings_.topics.find(name);
  Topic topic;
  topic.name = given != settings_.topics.end() ? given->second : "/" + word_of(name);
  const bool is_large = type == ros::sensor_msgs::Image::kType || type == ros::sensor_msgs::PointCloud2::kType;
  const dds::Quality quality{.reliable = settings_.is_reliable, .latched = false, .depth = is_large ? 10 : 200};
  topic.writer = std::make_unique<dds::Writer>(participant_, topic.name, type, quality, kPatienceOfSensors);
  return topics_.emplace(std::pair(sensor, type), std::move(topic)).first->second;
}

void MeasurementTopics::leave_out(std::string_view sensor, std::string_view why) {
  if (std::exchange(is_left_out_[std::string(sensor)], true)) return;
  events_.add(fmt::format("{} is not published: {}", sensor, why));
}

void MeasurementTopics::publish(const Measurement& measurement) {
  const std::size_t sensor = measurement.sensor;
  const ros::std_msgs::Header header = ros::to_ros_header(measurement.stamp, frame_of(sensor));
  try {
    TypedMessage message = message_of(*measurement.payload, header, settings_, datum_);
    publisher_.send(*topic_of(sensor, message.type).writer, std::move(message.cdr), measurement.stamp);
  } catch (const ros::Unusable& unusable) {
    return leave_out(rig_.mountings().at(sensor).name, unusable.what());
  }
  if (measurement.payload->type() == Image::kType) publish_camera_info(sensor, header);
}

/// Beside the pictures: /camera/camera_info of /camera/image_raw.
void MeasurementTopics::publish_camera_info(std::size_t sensor, const ros::std_msgs::Header& header) {
  const Mounting& mounting = rig_.mountings().at(sensor);
  if (!mounting.intrinsics) return;
  const std::string type(ros::sensor_msgs::CameraInfo::kType);
  auto known = topics_.find({sensor, type});
  if (known == topics_.end()) {
    const auto given = settings_.topics.find(mounting.name);
    const std::string picture = given != settings_.topics.end() ? given->second : "/" + word_of(mounting.name);
    Topic topic;
    topic.name = picture.substr(0, picture.rfind('/')) + "/camera_info";
    const dds::Quality quality{.reliable = settings_.is_reliable, .latched = false, .depth = 10};
    topic.writer = std::make_unique<dds::Writer>(participant_, topic.name, type, quality, kPatienceOfSensors);
    known = topics_.emplace(std::pair(sensor, type), std::move(topic)).first;
  }
  publisher_.send(*known->second.writer, ros::to_cdr(camera_info(*mounting.intrinsics, header)), {});
}

void MeasurementTopics::wait_for_readers(std::chrono::milliseconds limit) {
  const auto end = std::chrono::steady_clock::now() + limit;
  for (auto& [key, topic] : topics_) {
    const auto left = std::max(end - std::chrono::steady_clock::now(), std::chrono::steady_clock::duration::zero());
    topic.writer->wait_for_readers(left);
  }
}

std::uint64_t MeasurementTopics::left_out() const {
  std::uint64_t sum = 0;
  for (const auto& [key, topic] : topics_) sum += topic.writer->left_out();
  return sum;
}

}  // namespace waymark::ros2_publisher
