// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/cdr/definition_text.hpp"

namespace waymark::ros {

std::string short_message_name(std::string_view type) {
  const std::size_t first = type.find('/');
  const std::size_t last = type.rfind('/');
  if (first == std::string_view::npos) return std::string(type);
  return std::string(type.substr(0, first)) + std::string(type.substr(last));
}

std::string join_definition(const DefinitionParts& parts) {
  std::string text;
  for (const auto& [name, lines] : parts) {
    if (!text.empty()) text += std::string(80, '=') + "\nMSG: " + name + "\n";
    text += lines;
  }
  return text;
}

}  // namespace waymark::ros
