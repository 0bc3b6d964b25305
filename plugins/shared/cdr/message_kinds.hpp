// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "plugins/shared/cdr/conversions.hpp"
#include "plugins/shared/cdr/wire_reader.hpp"
#include "waymark/config/config.hpp"
#include "waymark/interface/measurement.hpp"

namespace waymark::ros {

/// What a message holds.
struct Decoded {
  std::optional<Time> stamp;         ///< of its header; nothing: it has none (zero)
  Duration before{};                 ///< how long before its stamp the payload is valid: the interval of an increment
  std::shared_ptr<Payload> payload;  ///< null: none yet, as of the first pose of an odometry
};

/// Makes payloads of the messages of one topic, in their order. Throws Unusable for a message that does not hold what
/// its type defines, or values that are not finite.
using Decoder = std::function<Decoded(WireReader)>;

/// How messages become payloads, from the YAML.
struct DecoderSettings {
  WheelJoints wheels;
};

/// Reads the keys of an entry of `channels`.
DecoderSettings read_decoder_settings(const Config& entry);

/// A type of message and one payload that can be made of it.
struct MessageKind {
  std::string_view type;      ///< "sensor_msgs/msg/Imu"
  std::string_view ros1_md5;  ///< of its definition in ROS 1
  std::string_view payload;   ///< "waymark/ImuSample@1"
  std::string (*definition)();
  /// Throws ConfigError if a setting is missing.
  Decoder (*make)(const DecoderSettings& settings, const Config& entry);
};

/// All of them; of several for one type the first is the usual one.
std::span<const MessageKind> message_kinds();

}  // namespace waymark::ros
