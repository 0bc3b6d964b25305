// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/json_messages/base64.hpp"

#include <algorithm>
#include <array>

namespace waymark::json_messages {
namespace {

constexpr std::string_view kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
constexpr std::uint8_t kNone = 0xff;
constexpr std::size_t kBytes = 3;  // are four letters of six bits
constexpr std::size_t kGroup = 4;

constexpr std::array<std::uint8_t, 256> make_values() {
  std::array<std::uint8_t, 256> values{};
  values.fill(kNone);
  for (std::size_t i = 0; i < kLetters.size(); ++i)
    values[static_cast<std::uint8_t>(kLetters[i])] = static_cast<std::uint8_t>(i);
  return values;
}
constexpr std::array<std::uint8_t, 256> kValues = make_values();

}  // namespace

std::string to_base64(std::span<const std::uint8_t> bytes) {
  std::string text;
  text.reserve((bytes.size() + kBytes - 1) / kBytes * kGroup);
  for (std::size_t i = 0; i < bytes.size(); i += kBytes) {
    const std::size_t count = std::min(kBytes, bytes.size() - i);
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < kBytes; ++k) bits = bits << 8U | (k < count ? bytes[i + k] : 0U);
    for (std::size_t k = 0; k < kGroup; ++k) text += k <= count ? kLetters[bits >> (18U - 6U * k) & 63U] : '=';
  }
  return text;
}

std::optional<std::vector<std::uint8_t>> from_base64(std::string_view text) {
  const std::size_t padding = text.ends_with("==") ? 2 : text.ends_with('=') ? 1 : 0;
  if (padding > 0 && text.size() % kGroup != 0) return std::nullopt;
  text.remove_suffix(padding);
  if (text.size() % kGroup == 1) return std::nullopt;
  std::vector<std::uint8_t> bytes;
  bytes.reserve(text.size() / kGroup * kBytes + kBytes);
  std::uint32_t bits = 0;
  unsigned count = 0;
  for (const char letter : text) {
    const std::uint8_t value = kValues[static_cast<std::uint8_t>(letter)];
    if (value == kNone) return std::nullopt;
    bits = bits << 6U | value;
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes.push_back(static_cast<std::uint8_t>(bits >> count & 0xffU));
  }
  return bytes;
}

}  // namespace waymark::json_messages
