// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "plugins/shared/cdr/message_kinds.hpp"
#include "waymark/config/config.hpp"

namespace waymark::message_log {

/// A decoder that turns the sign of the numbers `names` of each payload of `decode`: for a sensor whose axes point the
/// other way, odometry that counts left as negative. Throws ConfigError at `negate` of the entry if the payload has no
/// such number.
ros::Decoder negated(ros::Decoder decode, std::string_view payload_type, std::vector<std::string> names,
                     const Config& entry);

}  // namespace waymark::message_log
