// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "waymark/interface/map_module.hpp"
#include "waymark/plugin/descriptor.hpp"

/// The header for a map module plugin. The plugin is one class and one line:
///
///     WAYMARK_PLUGIN(waymark::MapModule, DockMap, "dock_map", "1.0.0")
