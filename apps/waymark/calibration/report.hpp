// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "apps/waymark/calibration/estimate.hpp"
#include "apps/waymark/calibration/parameter.hpp"
#include "apps/waymark/calibration/standing.hpp"

namespace waymark::calibration {

/// All that was found out about one robot.
struct Findings {
  std::string time_base;         ///< the sensor of motion against whose stamps delays count
  double time_base_delay = 0.0;  ///< what the YAML gives it [s]
  std::vector<Parameter> parameters;
  Estimate estimate;  ///< of these
  std::vector<Standing> standing;
};

/// The estimate as a table: given, estimated, σ, and what the drive did not determine.
std::string table(const Findings& findings, const Values& values);

/// The IMUs at rest, a table each: Allan deviations, and the bias of the gyro. Empty if none stood.
std::string standing_tables(const Findings& findings);

/// The keys that were determined, as a YAML that repeats `sensors:`, with σ and the given value in comments.
std::string yaml_block(const Findings& findings, const Values& values, const std::string& heading);

/// All of it as JSON: a list of {name, unit, given, estimated, sigma, determined}; of an IMU at rest
/// `gyro_noise_rad_per_sqrt_s` and `gyro_bias_radps[0]` to `[2]`, which no key holds (`given` is null).
std::string json(const Findings& findings, const Values& values);

/// What was determined as overrides for the command line. Nothing is stamped before it happens, so a delay that comes
/// out negative is one of the time base: all delays grow by it.
std::vector<Config::Override> overrides(const Findings& findings, const Values& values);

}  // namespace waymark::calibration
