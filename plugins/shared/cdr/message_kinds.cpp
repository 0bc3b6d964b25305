// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/cdr/message_kinds.hpp"

#include <array>
#include <utility>

#include "plugins/shared/cdr/definition_text.hpp"
#include "plugins/shared/cdr/message.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::ros {
namespace {

template <Message M>
M read_whole(WireReader in) {
  M message;
  read(in, message);
  require_end(in, M::kType);
  return message;
}

/// A decoder of messages M with a function that makes the payload.
template <Message M, auto Convert>
Decoder make_decoder(const DecoderSettings&, const Config&) {
  return [](WireReader in) {
    auto message = read_whole<M>(in);
    const auto stamp = to_time(message.header.stamp);
    return Decoded{stamp, {}, Convert(std::move(message))};
  };
}

template <Message M, auto Convert>
constexpr MessageKind kind(std::string_view ros1_md5, std::string_view payload) {
  return {M::kType, ros1_md5, payload, definition_text<M>, make_decoder<M, Convert>};
}

constexpr auto kImu = [](const sensor_msgs::Imu& m) { return to_imu_sample(m); };
constexpr auto kField = [](const sensor_msgs::MagneticField& m) { return to_magnetic_field(m); };
constexpr auto kFix = [](const sensor_msgs::NavSatFix& m) { return to_gnss_fix(m); };
constexpr auto kScan = [](sensor_msgs::LaserScan m) { return to_laser_scan(std::move(m)); };
constexpr auto kCloud = [](const sensor_msgs::PointCloud2& m) { return to_point_cloud(m); };
constexpr auto kImage = [](const sensor_msgs::Image& m) { return to_image(m); };
constexpr auto kCompressed = [](sensor_msgs::CompressedImage m) { return to_image(std::move(m)); };
constexpr auto kTwistOfOdometry = [](const nav_msgs::Odometry& m) { return to_body_twist(m.twist.twist); };
constexpr auto kHeightOfOdometry = [](const nav_msgs::Odometry& m) { return to_height(m.pose); };
constexpr auto kTwist = [](const geometry_msgs::TwistStamped& m) { return to_body_twist(m.twist); };
constexpr auto kTwistWithCovariance = [](const geometry_msgs::TwistWithCovarianceStamped& m) {
  return to_body_twist(m.twist.twist);
};
constexpr auto kHeightOfPose = [](const geometry_msgs::PoseStamped& m) { return to_height(m.pose); };
constexpr auto kHeightOfPoseWithCovariance = [](const geometry_msgs::PoseWithCovarianceStamped& m) {
  return to_height(m.pose);
};

/// Poses, from one to the next.
template <Message M, auto PoseOf>
Decoder increments(const DecoderSettings&, const Config&) {
  return [poses = IncrementsOfPoses()](WireReader in) mutable {
    const auto message = read_whole<M>(in);
    const auto stamp = to_time(message.header.stamp);
    if (!stamp) throw Unusable("its header has no stamp, which the motion between two poses needs");
    const auto increment = poses.add(*stamp, PoseOf(message));
    return increment ? Decoded{stamp, *stamp - increment->stamp, increment->payload} : Decoded{stamp, {}, nullptr};
  };
}

constexpr auto kPoseOfOdometry = [](const nav_msgs::Odometry& m) -> const geometry_msgs::Pose& { return m.pose.pose; };
constexpr auto kPose = [](const geometry_msgs::PoseStamped& m) -> const geometry_msgs::Pose& { return m.pose; };

Decoder wheel_speeds(const DecoderSettings& settings, const Config& entry) {
  const WheelJoints& wheels = settings.wheels;
  if (wheels.left.empty() || wheels.right.empty() || wheels.radius_m <= 0.0)
    entry.fail("wheels", "sensor_msgs/JointState needs wheels: { left: [joint], right: [joint], radius_m: 0.1 }");
  return [wheels](WireReader in) {
    const auto message = read_whole<sensor_msgs::JointState>(in);
    return Decoded{to_time(message.header.stamp), {}, to_wheel_speeds(message, wheels)};
  };
}

constexpr std::string_view kOdometryMd5 = "cd5e73d190d741a2f92e81eda573aca7";
constexpr std::string_view kPoseStampedMd5 = "d3812c3cbc69362b77dc0b19b345f8f5";

constexpr std::array kKinds{
    kind<sensor_msgs::Imu, kImu>("6a62c6daae103f4ff57a132d6f95cec2", ImuSample::kType),
    kind<sensor_msgs::MagneticField, kField>("2f3b0b43eed0c9501de0fa3ff89a45aa", MagneticField::kType),
    kind<sensor_msgs::NavSatFix, kFix>("2d3a8cd499b9b4a0249fb98fd05cfa48", GnssFix::kType),
    kind<nav_msgs::Odometry, kTwistOfOdometry>(kOdometryMd5, BodyTwist::kType),
    kind<nav_msgs::Odometry, kHeightOfOdometry>(kOdometryMd5, Height::kType),
    MessageKind{nav_msgs::Odometry::kType, kOdometryMd5, PoseIncrement::kType, definition_text<nav_msgs::Odometry>,
                increments<nav_msgs::Odometry, kPoseOfOdometry>},
    kind<geometry_msgs::TwistStamped, kTwist>("98d34b0043a2093cf9d9345ab6eef12e", BodyTwist::kType),
    kind<geometry_msgs::TwistWithCovarianceStamped, kTwistWithCovariance>("8927a1a12fb2607ceea095b2dc440a96",
                                                                          BodyTwist::kType),
    kind<sensor_msgs::LaserScan, kScan>("90c7ef2dc6895d81024acba2ac42f369", LaserScan::kType),
    kind<sensor_msgs::PointCloud2, kCloud>("1158d486dd51d683ce2f1be655c3c181", PointCloud::kType),
    kind<sensor_msgs::Image, kImage>("060021388200f6f0f447d0fcd9c64743", Image::kType),
    kind<sensor_msgs::CompressedImage, kCompressed>("8f7a12909da2c9d3332d540a0977563f", Image::kType),
    MessageKind{sensor_msgs::JointState::kType, "3066dcd76a6cfaef579bd0f34173e9fd", WheelSpeeds::kType,
                definition_text<sensor_msgs::JointState>, wheel_speeds},
    MessageKind{geometry_msgs::PoseStamped::kType, kPoseStampedMd5, PoseIncrement::kType,
                definition_text<geometry_msgs::PoseStamped>, increments<geometry_msgs::PoseStamped, kPose>},
    kind<geometry_msgs::PoseStamped, kHeightOfPose>(kPoseStampedMd5, Height::kType),
    kind<geometry_msgs::PoseWithCovarianceStamped, kHeightOfPoseWithCovariance>("953b798c0f514ff060a53a3498ce6246",
                                                                                Height::kType),
};

}  // namespace

DecoderSettings read_decoder_settings(const Config& entry) {
  DecoderSettings settings;
  const Config wheels = entry.child_or_empty({"wheels", "of `sensor_msgs/JointState`: which joints are wheels"});
  settings.wheels.left =
      wheels.texts({"left", "joints of the wheels on the left; their mean speed counts"}, std::vector<std::string>{});
  settings.wheels.right = wheels.texts({"right", "the same on the right"}, std::vector<std::string>{});
  settings.wheels.radius_m = wheels.non_negative({"radius_m", "m", "radius of the wheels"}, 0.0);
  return settings;
}

std::span<const MessageKind> message_kinds() { return kKinds; }

}  // namespace waymark::ros
