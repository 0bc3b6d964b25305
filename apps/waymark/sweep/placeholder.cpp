// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/sweep/placeholder.hpp"

namespace waymark::sweep {

std::string filled(std::string text, std::string_view name, std::string_view value) {
  for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name, at + value.size()))
    text.replace(at, name.size(), value);
  return text;
}

}  // namespace waymark::sweep
