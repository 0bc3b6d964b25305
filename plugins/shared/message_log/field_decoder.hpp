// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "plugins/shared/cdr/message_kinds.hpp"
#include "waymark/config/config.hpp"

namespace waymark::message_log {

/// Makes payloads of messages that no struct stands for, by their recorded definition. `fields` of the YAML gives each
/// field of the payload that consists of numbers the path of one in the message ("velocity.x", "-velocity.y"), or a
/// number. Throws ConfigError for a path that the definition lacks, a field that the payload lacks, or one that it
/// needs.
ros::Decoder make_field_decoder(std::string_view type, const std::string& definition, std::string_view payload_type,
                                const Config& entry);

}  // namespace waymark::message_log
