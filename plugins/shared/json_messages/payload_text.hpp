// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "plugins/shared/json_messages/message.hpp"
#include "waymark/interface/measurement.hpp"

namespace waymark::json_messages {

/// A core payload with the fields of the message. Null or absent is the value that means "not known", or the default of
/// a field that is not required. `payload_type` is a versioned name of core. Throws BadMessage, also for a key that is
/// no field, and for values that the payload does not allow.
std::shared_ptr<const Payload> read_payload(const Message& message, std::string_view payload_type);

/// The line of a message, without its end: the inverse of `parse_message` and `read_payload`. Fields that are not
/// required and not known are left out. Doubles are written so that they are read back to the bit.
std::string write_message(std::string_view sensor, std::optional<Time> stamp, const Payload& payload);

/// A text as JSON, with quotes; bytes that are not UTF-8 are replaced.
std::string json_text(std::string_view text);

}  // namespace waymark::json_messages
