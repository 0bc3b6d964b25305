// SPDX-License-Identifier: Apache-2.0
#include "joint/white_match.hpp"

#include "waymark/math/gaussian.hpp"

namespace waymark::joint {

WhiteMatch whiten(const Eigen::Matrix3d& information, const Eigen::Vector3d& gradient) {
  const gaussian::Eigen3 eigen = gaussian::eigen(information);
  const Eigen::Vector3d root = eigen.values.cwiseSqrt();
  WhiteMatch white;
  white.W = root.asDiagonal() * eigen.vectors.transpose();
  const Eigen::Vector3d rotated = eigen.vectors.transpose() * gradient;
  for (int i = 0; i < 3; ++i) white.target[i] = root[i] > 0.0 ? rotated[i] / root[i] : 0.0;
  return white;
}

}  // namespace waymark::joint
