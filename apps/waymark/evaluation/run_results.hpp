// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>

#include "waymark/interface/sensor.hpp"

namespace waymark::evaluation {

/// What a run left in its output folder, for scoring. An empty path: the run has not written it.
struct RunResults {
  std::filesystem::path estimate;              ///< the online trajectory of the sink tum
  std::filesystem::path reference;             ///< the source's reference, else the fixes that were held out
  std::filesystem::path covariance;            ///< of the sink tum
  std::filesystem::path diagnostics;           ///< of that sink
  std::filesystem::path landmarks;             ///< of that sink, if the source knows the true ones
  std::filesystem::path survey;                ///< the true landmarks
  std::optional<Datum> datum;                  ///< of the configuration, else the one that the run chose
  std::optional<Eigen::Vector3d> lever_arm_m;  ///< of the antenna, if the reference is fixes of one
};

/// Finds them by the names in the run's config.yaml, or by the usual names if there is none. Throws Error if the folder
/// has no trajectory, ConfigError or DataError if a file in it cannot be read.
RunResults find_results(const std::filesystem::path& folder);

}  // namespace waymark::evaluation
