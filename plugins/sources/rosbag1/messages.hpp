// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "waymark/interface/measurement.hpp"
#include "wire.hpp"

namespace waymark::rosbag1 {

/// What a message holds.
struct Decoded {
  std::optional<Time> stamp;  ///< of its header; nothing: the header has none (zero)
  std::shared_ptr<const Payload> payload;
};

/// A type of message and one payload that can be made of it.
struct MessageKind {
  std::string_view type;     ///< "sensor_msgs/Imu"
  std::string_view md5;      ///< of its definition
  std::string_view payload;  ///< "waymark/ImuSample@1"
  /// Throws Unusable.
  std::shared_ptr<Payload> (*decode)(Wire& wire);
};

/// All of them; of several for one type the first is the usual one.
std::span<const MessageKind> message_kinds();

/// Reads a message. Throws Unusable if it does not hold what its type defines, or numbers that are not finite.
Decoded decode(const MessageKind& kind, Bytes message);

}  // namespace waymark::rosbag1
