// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "waymark/base/api.hpp"

namespace waymark {

/// A text as the content of an element of XML, SVG or HTML: `&`, `<` and `>` become entities, control characters "?".
WAYMARK_API std::string xml_text(std::string_view text);

}  // namespace waymark
