// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "plugins/shared/cdr/message_kinds.hpp"
#include "plugins/shared/dds/participant.hpp"
#include "plugins/shared/dds/raw_type.hpp"
#include "waymark/config/config.hpp"
#include "waymark/interface/rig.hpp"
#include "waymark/interface/source.hpp"

namespace waymark::ros2 {

/// An entry of `channels`: a topic, its type, and what becomes of its messages.
class TopicChannel {
 public:
  /// Throws ConfigError.
  TopicChannel(const Config& entry, const Rig& rig);

  const std::string& topic() const { return topic_; }
  const std::string& type() const { return type_; }
  const dds::Quality& quality() const { return quality_; }
  const Channel& channel() const { return channel_; }

  /// The measurement in a message, without channel and sequence; nothing if the message gives none yet. Throws
  /// Unusable.
  std::optional<Measurement> measure(const dds::Sample& sample) const;

  /// Frame of the sensor: that of the YAML, else the one in the header of a message. Throws Unusable if the message has
  /// none.
  std::string frame_of(const dds::Sample& sample) const;
  const std::string& given_frame() const { return frame_; }
  /// True if the frame is that of a camera's picture: z forward, x right, y down (REP 103).
  bool is_optical() const;

 private:
  void choose_decoder(const Config& entry, const std::string& payload, const ros::DecoderSettings& settings);

  std::string topic_;
  std::string type_;
  dds::Quality quality_;
  Channel channel_;
  std::string frame_;
  bool has_stamp_ = true;    // its messages have a header that counts
  bool is_payload_ = false;  // a payload of waymark as it is
  Duration stamp_offset_{};
  ros::Decoder decode_;
};

}  // namespace waymark::ros2
