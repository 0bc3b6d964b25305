// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

namespace waymark::config {

inline constexpr int kMaxDepth = 64;  ///< of lists and mappings in each other
inline constexpr std::size_t kMaxNodes =
    200'000;  ///< of a tree; aliases of aliases and variables in variables multiply

/// Of a key. YAML reads keys of up to 1024 characters, and a byte may be written with four.
inline constexpr std::size_t kMaxKeyBytes = 200;

/// Reads a YAML text without keeping it. Throws YAML::ParserException with the place if yaml-cpp would read it without
/// end (it finds one empty document after the other before a stray comma), if it holds more than one document, or if it
/// is nested deeper or has more nodes than a configuration may; and YAML::Exception for wrong syntax.
void check_yaml_bounds(const std::string& text);

}  // namespace waymark::config
