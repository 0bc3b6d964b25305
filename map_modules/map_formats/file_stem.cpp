// SPDX-License-Identifier: Apache-2.0
#include "file_stem.hpp"

#include <cctype>

namespace waymark::map_formats {

std::string FileStems::of(const std::string& map_name) {
  std::string stem = map_name;
  for (char& c : stem) {
    const bool is_plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-';
    if (!is_plain) c = '_';
  }
  std::string free = stem;
  for (int number = 2; !taken_.insert(free).second; ++number) free = stem + '_' + std::to_string(number);
  return free;
}

}  // namespace waymark::map_formats
