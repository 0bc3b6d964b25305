// SPDX-License-Identifier: Apache-2.0
#include "file_stem.hpp"

#include <cctype>

namespace waymark::map_formats {

std::string file_stem(std::string map_name) {
  for (char& c : map_name) {
    const bool is_plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-';
    if (!is_plain) c = '_';
  }
  return map_name;
}

}  // namespace waymark::map_formats
