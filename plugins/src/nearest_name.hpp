// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace waymark {

/// The name with the fewest single-letter edits from `asked`, if they are few enough for a typing error; else an empty
/// text.
std::string nearest_name(std::string_view asked, const std::vector<std::string>& names);

}  // namespace waymark
