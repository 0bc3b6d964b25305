// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "waymark/config/key_reference.hpp"
#include "waymark/plugin_loader.hpp"

namespace waymark::host {

/// The keys of a configuration without those of plugins: "filter.particles", "sensors[].delay_s".
std::vector<DescribedKey> robot_keys();

/// The keys of a plugin's own block. Throws PluginError if the loader does not find it, or finds it unfit.
std::vector<DescribedKey> plugin_keys(const PluginLoader& loader, const PluginInfo& plugin);

/// "`track_m`" with what it needs, as rows of a Markdown table: key, values, unit, default, meaning. Only keys below
/// `block` ("filter", "sensors[]"; empty: all), named without it; with `nested` false, only those right below it.
std::string key_table(const std::vector<DescribedKey>& keys, std::string_view block = {}, bool nested = true);

}  // namespace waymark::host
