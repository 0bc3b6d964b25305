// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "map_modules/feature_map/association/feature_association.hpp"
#include "map_modules/feature_map/feature_map_settings.hpp"
#include "map_modules/feature_map/feature_observation.hpp"

/// Which landmarks a detection may belong to at all. Both append to `association.pairs` and search among
/// `association.nearby`, which must hold all landmarks within reach. `pose` (x, y, yaw) and `P` are the prior.
namespace waymark::feature_map {

/// Pairs by place and signature: within the gate and likelier than a new landmark, whose log likelihood is `log_p0`,
/// (4.5)-(4.8).
template <int D>
void collect_pairs(const FeatureMapSettings& settings, double log_p0, const Eigen::Vector3d& pose,
                   const Eigen::Matrix3d& P, const FeatureObservation& observation, FeatureAssociation& association);

/// Pairs with one identity, within the wide gate of identities.
template <int D>
void collect_identity_pairs(const FeatureMapSettings& settings, const Eigen::Vector3d& pose, const Eigen::Matrix3d& P,
                            const FeatureObservation& observation, FeatureAssociation& association);

}  // namespace waymark::feature_map
