// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace waymark::map_formats {

/// A name as a scalar of YAML, in quotes where it needs them.
std::string quoted_if_needed(std::string_view name);

}  // namespace waymark::map_formats
