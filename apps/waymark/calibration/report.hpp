// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "apps/waymark/calibration/estimate.hpp"
#include "apps/waymark/calibration/parameter.hpp"

namespace waymark::calibration {

/// The estimate as a table: given, estimated, σ, and what the drive did not determine.
std::string table(const std::vector<Parameter>& parameters, const Values& values, const Estimate& estimate);

/// The keys that the drive determined, as a YAML that repeats `sensors:`, with σ and the given value in comments.
std::string yaml_block(const std::vector<Parameter>& parameters, const Values& values, const Estimate& estimate,
                       const std::string& heading);

/// All of it as JSON: a list of {name, unit, given, estimated, sigma, determined}.
std::string json(const std::vector<Parameter>& parameters, const Values& values, const Estimate& estimate);

/// What the drive determined as overrides for the command line.
std::vector<Config::Override> overrides(const std::vector<Parameter>& parameters, const Values& values,
                                        const Estimate& estimate);

}  // namespace waymark::calibration
