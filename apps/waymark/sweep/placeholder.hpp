// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace waymark::sweep {

/// The text with a value in place of each `name`, such as "{seed}". What the value contains is not replaced again.
std::string filled(std::string text, std::string_view name, std::string_view value);

}  // namespace waymark::sweep
