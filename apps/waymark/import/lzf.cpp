// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/import/lzf.hpp"

namespace waymark::imports {

std::optional<std::string> unpack_lzf(std::string_view packed, std::size_t size) {
  constexpr std::size_t kLiterals = 32;  // a smaller control byte is followed by so many bytes, and one more
  std::string out;
  std::size_t at = 0;
  const auto byte = [&packed](std::size_t i) {
    return static_cast<std::size_t>(static_cast<unsigned char>(packed[i]));
  };
  while (at < packed.size()) {
    const std::size_t control = byte(at++);
    if (control < kLiterals) {
      const std::size_t count = control + 1;
      if (count > packed.size() - at || count > size - out.size()) return std::nullopt;
      out.append(packed.substr(at, count));
      at += count;
      continue;
    }
    // What was unpacked before, again: three bits of length and five of distance, or a byte more of each.
    constexpr std::size_t kLong = 7;
    std::size_t length = control >> 5;
    if (length == kLong) {
      if (at == packed.size()) return std::nullopt;
      length += byte(at++);
    }
    length += 2;
    if (at == packed.size()) return std::nullopt;
    const std::size_t distance = ((control & 0x1f) << 8 | byte(at++)) + 1;
    if (distance > out.size() || length > size - out.size()) return std::nullopt;
    for (std::size_t i = 0; i < length; ++i) out += out[out.size() - distance];  // may overlap itself
  }
  return out.size() == size ? std::optional(std::move(out)) : std::nullopt;
}

}  // namespace waymark::imports
