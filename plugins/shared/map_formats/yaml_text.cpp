// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/map_formats/yaml_text.hpp"

#include <algorithm>
#include <cctype>

namespace waymark::map_formats {

std::string quoted_if_needed(std::string_view name) {
  const auto is_plain = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '.'; };
  if (!name.empty() && std::isalnum(static_cast<unsigned char>(name.front())) != 0 &&
      std::ranges::all_of(name, is_plain)) {
    return std::string(name);
  }
  std::string quoted = "'";
  for (const char c : name) quoted += c == '\'' ? std::string("''") : std::string(1, c);
  return quoted + "'";
}

}  // namespace waymark::map_formats
