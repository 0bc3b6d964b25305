// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "waymark/config/config.hpp"

namespace waymark::host {

/// The effective configuration as a file to be run from any folder: relative paths in it count from that of the YAML.
std::string portable_config(const Config& yaml);

}  // namespace waymark::host
