// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "waymark/base/time.hpp"
#include "waymark/config/config.hpp"
#include "waymark/math/gaussian.hpp"

namespace waymark::calibration {

/// An innovation of the filter: what a measurement said beyond the prediction, and its covariance.
struct Innovation {
  std::uint64_t measurement = 0;  ///< its number in the log
  std::uint32_t update = 0;       ///< of the measurement's updates
  std::uint32_t sensor = 0;
  Time stamp;
  gaussian::Vector nu;
  gaussian::Matrix S;

  /// The same update of another run over the same log has the same.
  std::pair<std::uint64_t, std::uint32_t> id() const { return {measurement, update}; }
};

/// The innovations of one run over a log.
struct Run {
  std::vector<Innovation> innovations;  ///< by `id`
  std::vector<std::string> sensors;     ///< their names
  double duration_s = 0.0;              ///< of the log
};

/// Runs the robot of a YAML over its log, or its first part, and notes all innovations: of the sensors, and of the
/// maps, whose correction of the pose is one, with P⁻ − P⁺ as its covariance. Those of `inputs`, names of sensors, are
/// left out. Throws what `Robot::load` and sources throw, and Error if the filter never starts.
Run run_over_log(const std::filesystem::path& yaml, const std::vector<Config::Override>& overrides,
                 std::optional<double> until_s, const std::vector<std::string>& inputs);

}  // namespace waymark::calibration
