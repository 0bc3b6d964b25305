// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace waymark::joint {

/// A match with white noise: W d = target + N(0, I), with Λ = Wᵀ W; a direction without information has a row of zeros.
struct WhiteMatch {
  Eigen::Matrix3d W;
  Eigen::Vector3d target;
};

/// Of the likelihood exp(ηᵀ d − ½ dᵀ Λ d).
WhiteMatch whiten(const Eigen::Matrix3d& information, const Eigen::Vector3d& gradient);

}  // namespace waymark::joint
