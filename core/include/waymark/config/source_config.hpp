// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

#include "waymark/base/api.hpp"
#include "waymark/config/config.hpp"
#include "waymark/interface/rig.hpp"
#include "waymark/interface/source.hpp"

namespace waymark {

/// What sources read from the YAML, each in the same words.

/// The channel from an entry of a source to the sensor that it names (`sensor: lidar`). Throws ConfigError if the robot
/// has no such sensor, or one that takes another payload; `giver` is what gives this one ("this", "/scan").
WAYMARK_API Channel channel_to_sensor(const Config& entry, const Rig& rig, std::string_view payload,
                                      std::string_view giver = "this");

/// The file that a key names, relative to the YAML. Throws ConfigError if it cannot be read or is a folder.
WAYMARK_API std::filesystem::path readable_file(const Config& config, const Config::Key& key);

}  // namespace waymark
