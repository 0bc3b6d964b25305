// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <string>
#include <string_view>

namespace waymark::command {

/// The text with control characters (ASCII and, in UTF-8, U+0080 to U+009F) in a form like `\x1b`, so that texts from
/// files cannot command a terminal. Newlines and tabs stay, and a carriage return in front, which rewrites a line.
inline std::string visible_text(std::string_view text) {
  std::string visible;
  visible.reserve(text.size());
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool stays = text[i] == '\n' || text[i] == '\t' || (text[i] == '\r' && i == 0);
    if (!stays && (byte(i) < 0x20 || byte(i) == 0x7f)) {
      visible += fmt::format("\\x{:02x}", byte(i));
    } else if (byte(i) == 0xc2 && i + 1 < text.size() && byte(i + 1) >= 0x80 && byte(i + 1) <= 0x9f) {
      visible += fmt::format("\\x{:02x}", byte(++i));
    } else {
      visible += text[i];
    }
  }
  return visible;
}

/// The same for a message: line feeds are made visible, too, but for one at its end.
inline std::string visible_line(std::string_view text) {
  std::string visible = visible_text(text);
  for (std::size_t at = visible.find('\n'); at != std::string::npos && at + 1 < visible.size();
       at = visible.find('\n', at))
    visible.replace(at, 1, "\\n");
  return visible;
}

}  // namespace waymark::command
