// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "map_modules/feature_map/signature.hpp"
#include "waymark/base/time.hpp"

namespace waymark::feature_map {

/// An augmented landmark: (east, north, radius) with one covariance, a signature, and whether it exists (§4).
struct Landmark {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();  ///< (east, north, radius) [m]
  Eigen::Matrix3d P = Eigen::Matrix3d::Zero();
  Eigen::Matrix2d P_floor = Eigen::Matrix2d::Zero();  ///< what the position can never be known better than: the pose's
                                                      ///< own covariance when it was written
  Signature signature;                                ///< empty until it was measured
  std::int32_t signature_views = 0;                   ///< how many views were fused
  std::int32_t identity = -1;  ///< the one that made it, where devices read identities; -1: unknown
  float log_odds = 0.0f;
  std::int32_t sightings = 0;
  std::int64_t id = -1;  ///< -1: none yet
  std::uint64_t birth =
      0;             ///< the detection that made it, the same in the maps of all particles; 0: none, it was loaded
  Time last_seen{};  ///< stamp of the last detection that was written; 0: none of this run
};

}  // namespace waymark::feature_map
