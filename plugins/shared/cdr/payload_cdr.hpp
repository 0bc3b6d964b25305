// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "plugins/shared/cdr/wire_reader.hpp"
#include "waymark/interface/measurement.hpp"

/// Payloads as CDR through their registered fields, exact to the bit. Numbers, vectors and quaternions are one float64
/// per name, whole numbers and enums int32, lists sequences.
namespace waymark::ros {

/// "waymark_msgs/msg/LaserScan" of "waymark/LaserScan@1".
std::string payload_message_type(std::string_view payload_type);

/// The definition (`ros2msg`) of the message that a payload becomes, with units and meanings as comments. Throws
/// Unusable for a payload without registered fields, and for one that is not of core and holds a list of less than
/// two elements with fields.
std::string payload_definition(const Payload& payload);

/// The same of a payload of core. Throws Unusable if there is none of that name.
std::string payload_definition(std::string_view payload_type);

/// Throws Unusable if the payload registers no fields.
std::vector<std::uint8_t> payload_to_cdr(const Payload& payload);

/// Reads a payload of core. Throws Unusable if it is none, or the bytes are not exactly such a payload. Its values are
/// not checked: see `Payload::problem`.
std::shared_ptr<Payload> payload_from_cdr(std::string_view payload_type, Bytes bytes);
std::shared_ptr<Payload> payload_from_cdr(std::string_view payload_type, WireReader in);

}  // namespace waymark::ros
