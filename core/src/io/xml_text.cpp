// SPDX-License-Identifier: Apache-2.0
#include "waymark/io/xml_text.hpp"

namespace waymark {

std::string xml_text(std::string_view text) {
  std::string result;
  for (const char c : text) {
    const bool is_control = static_cast<unsigned char>(c) < 0x20;
    result += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : is_control ? "?" : std::string(1, c);
  }
  return result;
}

}  // namespace waymark
