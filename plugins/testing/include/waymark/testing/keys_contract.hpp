// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <type_traits>

#include "waymark/config/config.hpp"
#include "waymark/interface/rig.hpp"
#include "waymark/testing/violations.hpp"

namespace waymark::testing {

/// Builds the plugin under test from its mapping of the YAML, and may throw it away.
using BuildPlugin = std::function<void(const Config&)>;

/// Builds a plugin of any kind from `yaml`, its mapping in a robot's YAML, as the host does, and checks
/// - it can be built, twice from the same text;
/// - every key of `yaml` is read, and a key that nobody knows is not, so that the host can refuse it;
/// - a value of a wrong kind is refused with ConfigError, for every key of `yaml`.
Violations check_keys(const BuildPlugin& build, const std::string& yaml);

/// The same for class Plugin, whose constructor takes (const Config&) or (const Config&, const Rig&).
template <class Plugin>
Violations check_keys(const std::string& yaml, const Rig& rig = Rig({})) {
  return check_keys(
      [&rig](const Config& config) {
        if constexpr (std::is_constructible_v<Plugin, const Config&, const Rig&>) {
          [[maybe_unused]] const Plugin plugin(config, rig);
        } else {
          [[maybe_unused]] const Plugin plugin(config);
        }
      },
      yaml);
}

}  // namespace waymark::testing
