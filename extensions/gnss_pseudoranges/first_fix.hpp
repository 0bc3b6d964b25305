// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "pseudoranges.hpp"
#include "receiver.hpp"

namespace waymark::gnss {

/// A position of the antenna from one epoch.
struct FirstFix {
  Eigen::Vector3d p_ecef;
  double sigma;  ///< per horizontal axis [m]
};

/// Weighted least squares with one clock per system; satellites that do not fit lose weight (Cauchy). Nothing if there
/// are too few satellites, or if they do not determine a position on the Earth.
std::optional<FirstFix> first_fix(const Pseudoranges& epoch, const Receiver& receiver);

}  // namespace waymark::gnss
