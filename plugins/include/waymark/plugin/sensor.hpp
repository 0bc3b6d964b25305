// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "waymark/interface/sensor.hpp"
#include "waymark/plugin/descriptor.hpp"

/// The header for a sensor plugin. The plugin is one class and one line:
///
///     WAYMARK_PLUGIN(waymark::Sensor, Altimeter, "altimeter", "1.0.0")
