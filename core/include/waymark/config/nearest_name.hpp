// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "waymark/base/api.hpp"

namespace waymark {

/// Edits of one character, or swaps of two neighbours, that turn a into b (optimal string alignment; F. Damerau,
/// Communications of the ACM 7(3), 1964).
WAYMARK_API std::size_t edit_distance(std::string_view a, std::string_view b);

/// The name nearest to what was asked for, if it is near enough for a typing error (max(2, a third of the length));
/// else empty.
WAYMARK_API std::string nearest_name(std::string_view asked, const std::vector<std::string>& names);

}  // namespace waymark
