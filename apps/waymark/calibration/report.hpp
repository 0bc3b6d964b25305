// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "apps/waymark/calibration/estimate.hpp"
#include "apps/waymark/calibration/magnetometer.hpp"
#include "apps/waymark/calibration/parameter.hpp"
#include "apps/waymark/calibration/standing.hpp"
#include "waymark/interface/finding.hpp"

namespace waymark::calibration {

/// All that was found out about one robot.
struct Findings {
  std::string time_base;         ///< the sensor of motion against whose stamps delays count
  double time_base_delay = 0.0;  ///< what the YAML gives it [s]
  std::vector<Parameter> parameters;
  Estimate estimate;  ///< of these
  std::vector<Standing> standing;
  std::vector<Magnetometer> magnetometers;
  std::vector<Finding> contradictions;  ///< of the diagnosis: signs, units, axes
};

/// The estimate as a table: given, estimated, σ, and what the drive did not determine.
std::string table(const Findings& findings, const Values& values);

/// The IMUs at rest, a table each: Allan deviations, and the bias of the gyro. Empty if none stood.
std::string standing_tables(const Findings& findings);

/// The magnetometers, some lines each: over which headings, hard and soft iron, what was not excited. Empty if there
/// are none.
std::string magnetometer_lines(const Findings& findings);

/// What the diagnosis found, a line each that begins with `start`; empty if nothing.
std::string contradiction_lines(const Findings& findings, std::string_view start);

/// The keys that were determined, as a YAML that repeats `sensors:`, with σ and the given value in comments;
/// and what the diagnosis found, as comments before.
std::string yaml_block(const Findings& findings, const Values& values, const std::string& heading);

/// All of it as JSON: a list of {name, unit, given, estimated, sigma, determined}; of an IMU at rest
/// `gyro_noise_rad_per_sqrt_s` and `gyro_bias_radps[0]` to `[2]`, which no key holds (`given` is null);
/// of a magnetometer the elements of `hard_iron_t` and `soft_iron`.
std::string json(const Findings& findings, const Values& values);

/// What was determined as overrides for the command line. Nothing is stamped before it happens, so a delay that comes
/// out negative is one of the time base: all delays grow by it.
std::vector<Config::Override> overrides(const Findings& findings, const Values& values);

}  // namespace waymark::calibration
