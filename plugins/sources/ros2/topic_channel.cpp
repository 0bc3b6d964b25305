// SPDX-License-Identifier: Apache-2.0
#include "topic_channel.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "plugins/shared/cdr/message.hpp"
#include "plugins/shared/cdr/payload_cdr.hpp"
#include "plugins/shared/cdr/ros/std_msgs.hpp"
#include "plugins/shared/dds/names.hpp"
#include "waymark/config/nearest_name.hpp"
#include "waymark/config/source_config.hpp"
#include "waymark/interface/payload_registry.hpp"

namespace waymark::ros2 {
namespace {

/// A name that DDS takes, or ConfigError.
void require_name(const Config& entry, std::string_view key, const std::string& name,
                  std::string (*mangle)(std::string_view)) {
  try {
    mangle(name);
  } catch (const std::invalid_argument& error) {
    entry.fail(key, error.what());
  }
}

/// "sensor_msgs/msg/Imu" of "sensor_msgs/Imu", too.
std::string with_msg(const std::string& type) {
  const std::size_t slash = type.find('/');
  return slash != std::string::npos && type.find('/', slash + 1) == std::string::npos
             ? type.substr(0, slash) + "/msg" + type.substr(slash)
             : type;
}

/// Of an image or a cloud: few of them are many bytes.
bool is_large(std::string_view type) { return type.ends_with("Image") || type.ends_with("PointCloud2"); }

}  // namespace

TopicChannel::TopicChannel(const Config& entry, const Rig& rig) {
  topic_ = entry.text({"topic", "its messages are read: /imu/data"});
  type_ = with_msg(entry.text({"type", "type of its messages: sensor_msgs/msg/Imu"}));
  const std::string payload =
      entry.text({"payload", "",
                  "what to make of a message that more than one payload can be made of (of `nav_msgs/msg/Odometry`: "
                  "`BodyTwist`, `Height` or `PoseIncrement`)",
                  "the first of them"},
                 "");
  has_stamp_ = entry.choice({"stamp",
                             "when a measurement was true: `header`: the stamp of the message's `header`; `arrival`: "
                             "the time at which it arrives"},
                            {"header", "arrival"}, "header") == "header";
  stamp_offset_ = from_seconds(
      entry.number_in({"stamp_offset_s", "s", "is added to the stamp: −0.02 for a device that stamps 20 ms too late"},
                      -3600.0, 3600.0, 0.0));
  quality_.reliable = entry.boolean(
      {"reliable", "true: what is lost on its way is sent again; a publisher of best effort is ignored then"}, false);
  constexpr std::int64_t kDepth = 200;
  constexpr std::int64_t kDepthOfLarge = 10;
  quality_.depth = static_cast<int>(
      entry.integer_in({"depth", "", "messages that wait until they are taken; a further one replaces the oldest",
                        "200; of images and clouds 10"},
                       1, 10000, is_large(type_) ? kDepthOfLarge : kDepth));
  frame_ = entry.text({"frame", "", "frame of the sensor in /tf_static, for `base_T_sensor: from_tf`",
                       "`frame_id` of the first message"},
                      "");
  const ros::DecoderSettings settings = ros::read_decoder_settings(entry);
  channel_.sensor =
      entry.text({"sensor", "a name under `sensors`; one topic may feed several sensors with different payloads"});
  require_name(entry, "topic", topic_, dds::topic_name);
  if (!topic_.starts_with('/')) topic_.insert(topic_.begin(), '/');
  require_name(entry, "type", type_, dds::type_name);
  choose_decoder(entry, payload, settings);
  channel_ = channel_to_sensor(entry, rig, channel_.payload_type, topic_);
}

void TopicChannel::choose_decoder(const Config& entry, const std::string& payload,
                                  const ros::DecoderSettings& settings) {
  const auto is_asked = [&](std::string_view type) {
    return payload.empty() || payload == type || payload == short_type_name(type);
  };
  std::vector<std::string> types;
  std::vector<std::string> payloads;
  for (const ros::MessageKind& kind : ros::message_kinds()) {
    types.emplace_back(kind.type);
    if (kind.type != type_) continue;
    payloads.emplace_back(short_type_name(kind.payload));
    if (decode_ || !is_asked(kind.payload)) continue;
    channel_.payload_type = kind.payload;
    decode_ = kind.make(settings, entry);
  }
  for (const KnownPayload& known : known_payloads()) {
    types.push_back(ros::payload_message_type(known.type));
    if (type_ != types.back()) continue;
    payloads.emplace_back(short_type_name(known.type));
    if (!is_asked(known.type)) continue;
    is_payload_ = true;
    channel_.payload_type = known.type;
    decode_ = [type = known.type](const ros::WireReader& in) {
      return ros::Decoded{std::nullopt, {}, ros::payload_from_cdr(type, in)};
    };
  }
  if (decode_) return;
  if (!payloads.empty()) {
    entry.fail("payload",
               fmt::format("{} cannot be made of {}; {} is expected", payload, type_, fmt::join(payloads, " or ")));
  }
  types.erase(std::unique(types.begin(), types.end()), types.end());  // clang 14 compiles no std::ranges::unique
  const std::string nearest = nearest_name(type_, types);
  entry.fail("type", fmt::format("{} cannot be read{}; types that can: {}", type_,
                                 nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest),
                                 fmt::join(types, ", ")));
}

std::optional<Measurement> TopicChannel::measure(const dds::Sample& sample) const {
  ros::Decoded decoded = decode_(ros::WireReader::cdr(sample.bytes()));
  if (!decoded.payload) return std::nullopt;
  if (is_payload_) {
    // These have no header: their stamp is the time that their writer gave them.
    decoded.stamp = Time{Duration{sample.written_ns()}};
    const std::string problem = decoded.payload->problem();
    if (!problem.empty()) throw ros::Unusable(problem);
  }
  Measurement measurement;
  measurement.payload = std::move(decoded.payload);
  measurement.stamp = kUnknownStamp;
  if (has_stamp_ && decoded.stamp) {
    const auto stamp = moved(*decoded.stamp, stamp_offset_ - decoded.before);
    if (!stamp) throw ros::Unusable("its stamp lies more than 146 years from the epoch");
    measurement.stamp = *stamp;
  } else if (decoded.before != Duration::zero()) {
    throw ros::Unusable("the motion between two poses needs their stamps: `stamp: header`");
  }
  return measurement;
}

std::string TopicChannel::frame_of(const dds::Sample& sample) const {
  if (!frame_.empty()) return frame_;
  if (is_payload_) throw ros::Unusable(fmt::format("{} has no header; `frame` is needed", type_));
  ros::WireReader in = ros::WireReader::cdr(sample.bytes());
  ros::std_msgs::Header header;
  ros::read(in, header);
  if (header.frame_id.empty()) throw ros::Unusable("its header has no frame_id; `frame` is needed");
  return header.frame_id;
}

bool TopicChannel::is_optical() const { return channel_.payload_type == Image::kType; }

}  // namespace waymark::ros2
