// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "waymark/interface/sink.hpp"
#include "waymark/plugin/descriptor.hpp"

/// The header for a sink plugin. The plugin is one class and one line:
///
///     WAYMARK_PLUGIN(waymark::Sink, Distance, "distance", "1.0.0")
