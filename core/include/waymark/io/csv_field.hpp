// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "waymark/base/api.hpp"

namespace waymark {

/// A text as a field of a CSV row, quoted where it must be (RFC 4180): a comma or a quote in a name must not tear a
/// row.
WAYMARK_API std::string csv_field(std::string_view text);

}  // namespace waymark
