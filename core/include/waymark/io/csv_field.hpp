// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "waymark/base/api.hpp"

namespace waymark {

/// A text as a field of a CSV row, quoted if it contains a comma, a quote or a line break (RFC 4180).
WAYMARK_API std::string csv_field(std::string_view text);
/// A number with so many decimals; empty if it is unknown (not finite).
WAYMARK_API std::string csv_field(double value, int decimals);

}  // namespace waymark
