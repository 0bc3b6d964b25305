// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Cholesky>
#include <array>

#include "waymark/interface/particle_map.hpp"

namespace waymark {

namespace {

using Three = std::array<int, 3>;

constexpr Three kPlanar{0, 1, 5};
constexpr Three kOther{2, 3, 4};

SpatialInformation::Marginal marginal(const SpatialInformation& about, const Three& kept, const Three& others) {
  // A direction of the others that the match does not constrain has no inverse.
  constexpr double kLeast = 1e-6;
  const Eigen::Matrix3d rest = about.information(others, others) + kLeast * Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d mixed = about.information(kept, others);
  const Eigen::Matrix3d gain = rest.llt().solve(mixed.transpose()).transpose();
  const Eigen::Matrix3d information = about.information(kept, kept) - gain * mixed.transpose();
  return {0.5 * (information + information.transpose()), about.gradient(kept) - gain * about.gradient(others)};
}

}  // namespace

SpatialInformation::Marginal SpatialInformation::planar() const { return marginal(*this, kPlanar, kOther); }
SpatialInformation::Marginal SpatialInformation::height_and_tilt() const { return marginal(*this, kOther, kPlanar); }

}  // namespace waymark
