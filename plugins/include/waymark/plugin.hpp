// SPDX-License-Identifier: Apache-2.0
#pragma once

/// All four kinds of plugin at once. A file that holds one plugin is rebuilt less often with the header of its kind.
#include "waymark/plugin/map_module.hpp"
#include "waymark/plugin/sensor.hpp"
#include "waymark/plugin/sink.hpp"
#include "waymark/plugin/source.hpp"
