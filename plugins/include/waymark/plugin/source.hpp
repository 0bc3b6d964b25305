// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "waymark/interface/source.hpp"
#include "waymark/plugin/descriptor.hpp"

/// The header for a source plugin. The plugin is one class and one line:
///
///     WAYMARK_PLUGIN(waymark::Source, Circle, "circle", "1.0.0")
