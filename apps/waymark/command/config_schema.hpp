// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "waymark/config/key_reference.hpp"

namespace waymark::command {

/// The keys of one plugin.
struct PluginKeys {
  std::string kind;  ///< "sensor", "map_module", "source", "sink"
  std::string name;
  std::vector<DescribedKey> keys;
};

/// JSON schema (draft 7) of a configuration: the robot's keys, and for each `plugin` those of that plugin. For editors:
/// a value may be a variable, `${name}`, wherever a value may be. Ends with a newline.
std::string config_schema(const std::vector<DescribedKey>& robot, const std::vector<PluginKeys>& plugins);

}  // namespace waymark::command
