// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "map_modules/feature_map/association/feature_association.hpp"
#include "map_modules/feature_map/feature_map_settings.hpp"
#include "map_modules/feature_map/feature_observation.hpp"
#include "map_modules/feature_map/landmarks/landmark_store.hpp"

namespace waymark::feature_map {

/// Decides which landmark each detection belongs to, at most one detection per landmark: fills
/// `association.landmark_of` and the marks `taken` of `association.nearby`, which must hold all landmarks within reach.
/// `pose` (x, y, yaw) and `P` are the prior, `log_p0` the log likelihood of a new landmark.
///
/// By place (and signature): pairs within the gate and likelier than a new landmark, (4.5)-(4.8); an identity that is a
/// signature makes no second landmark with the same one. By identity
/// (`IdentityUse::known`): the landmark with that identity, within a wide gate. A detection that fails it, or whose
/// landmark is out of reach or taken, or that has no identity, is ambiguous: it never makes a second landmark with one
/// identity. An identity that no landmark of the map has makes a new one.
template <int D>
void associate(const LandmarkStore& store, const FeatureMapSettings& settings, double log_p0,
               const Eigen::Vector3d& pose, const Eigen::Matrix3d& P, const FeatureObservation& observation,
               FeatureAssociation& association);

}  // namespace waymark::feature_map
