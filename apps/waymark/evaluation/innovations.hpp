// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace waymark::evaluation {

/// The normalised innovations squared (NIS) of one sensor over a run, with what their mean may be if the sensor's noise
/// and the filter's covariance are right: two-sided 95 % bounds of χ² with `dof` degrees of freedom, divided by
/// `updates` (Bar-Shalom, Li, Kirubarajan, 2001, §5.4; innovations of a right filter are independent).
struct InnovationScore {
  std::string sensor;
  std::uint64_t updates = 0;
  std::uint64_t dof = 0;  ///< rows of all updates
  double mean = 0.0;
  double expected = 0.0;
  double low = 0.0;
  double high = 0.0;
};

/// Reads diagnostics.json of the diagnostics sink; sensors without an update are left out. Throws DataError if it is no
/// such file.
std::vector<InnovationScore> read_innovations(const std::filesystem::path& diagnostics);

}  // namespace waymark::evaluation
