// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "config/node.hpp"

/// From a node's text to a typed value. All throw ConfigError at the node's place.
namespace waymark::config {

/// A finite number; notes its shortest form on the node.
double to_number(Node& node);

/// A whole number; 1e3 is one, 1.5 is not.
std::int64_t to_integer(Node& node);

/// true/false, yes/no, on/off.
bool to_boolean(Node& node);

/// Any scalar, as written.
std::string to_text(const Node& node);

}  // namespace waymark::config
