// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "map_modules/feature_map/association/feature_association.hpp"
#include "map_modules/feature_map/feature_map_settings.hpp"
#include "map_modules/feature_map/feature_observation.hpp"
#include "waymark/math/pose.hpp"

namespace waymark::feature_map {

/// Fills `association.missed`: nearby landmarks that should have been seen from this pose and belong to no detection.
/// Returns the log factor of the confirmed ones in the weight; without `negative_information` there are none.
double find_missed(const FeatureMapSettings& settings, const Pose& T_map_base, const FeatureObservation& observation,
                   FeatureAssociation& association);

}  // namespace waymark::feature_map
