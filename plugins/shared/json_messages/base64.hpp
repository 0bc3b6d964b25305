// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace waymark::json_messages {

/// Base64 with padding (RFC 4648, section 4).
std::string to_base64(std::span<const std::uint8_t> bytes);

/// The bytes; nothing if the text is not base64. The padding may be missing; line breaks are not allowed.
std::optional<std::vector<std::uint8_t>> from_base64(std::string_view text);

}  // namespace waymark::json_messages
