// SPDX-License-Identifier: Apache-2.0
#pragma once

/// The whole contract kit, for the check of one plugin: `return testing::report({testing::check_...(...), ...});`
#include "waymark/testing/keys_contract.hpp"
#include "waymark/testing/map_module_contract.hpp"
#include "waymark/testing/measurements.hpp"
#include "waymark/testing/sensor_contract.hpp"
#include "waymark/testing/sink_contract.hpp"
#include "waymark/testing/source_contract.hpp"
#include "waymark/testing/violations.hpp"
