// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "waymark/config/config.hpp"
#include "waymark/interface/rig.hpp"
#include "waymark/interface/source.hpp"

namespace waymark::csv {

/// Reads the block `reference`: `trajectory` (time, x_m, y_m, optionally z_m and the attitude) and `landmarks` (x_m,
/// y_m, optionally name and radius_m), either or both. Throws ConfigError, or DataError at the first row that cannot be
/// used.
std::shared_ptr<const Reference> read_reference(const Config& config, const Rig& rig);

}  // namespace waymark::csv
