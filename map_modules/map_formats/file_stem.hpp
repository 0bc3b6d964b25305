// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace waymark::map_formats {

/// What a map is called in the YAML, as a file name without extension: characters other than letters, digits, `_` and
/// `-` become `_`.
std::string file_stem(std::string map_name);

}  // namespace waymark::map_formats
