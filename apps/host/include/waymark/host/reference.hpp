// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "waymark/config/key_reference.hpp"
#include "waymark/plugin_loader.hpp"

namespace waymark::host {

/// The keys of a configuration without those of plugins: "filter.particles", "sensors[].delay_s".
std::vector<DescribedKey> robot_keys();

/// The keys of a plugin's own block. Throws PluginError if the loader does not find it, or finds it unfit.
std::vector<DescribedKey> plugin_keys(const PluginLoader& loader, const PluginInfo& plugin);

/// The keys as a Markdown table: key, value, unit, default, meaning. What must be given beside a key is in its meaning.
std::string key_table(const std::vector<DescribedKey>& keys);

}  // namespace waymark::host
