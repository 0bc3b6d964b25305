// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "apps/waymark/calibration/magnetometer.hpp"
#include "waymark/config/config.hpp"

namespace waymark::calibration {

/// How far the readings go round, and how much their strength varies before and after; one line.
std::string summary(const Magnetometer& magnetometer);

/// Hard and soft iron as lines of the sensor's block of YAML, with σ and the given values in comments; as comments
/// alone if its plugin has no such keys, and empty if the drive did not determine them.
std::string yaml_lines(const Magnetometer& magnetometer);

/// The same for the command line: "sensors.compass.hard_iron_t=[…]". Empty under the same conditions.
std::vector<Config::Override> overrides(const Magnetometer& magnetometer);

/// One element of `hard_iron_t` or `soft_iron`.
struct IronElement {
  std::string name;  ///< "compass.hard_iron_t[0]"
  const char* unit;
  double given;
  double estimated;
  double sigma;
  bool is_determined;
};
std::vector<IronElement> elements(const Magnetometer& magnetometer);

}  // namespace waymark::calibration
