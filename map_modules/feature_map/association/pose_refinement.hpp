// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "map_modules/feature_map/association/feature_association.hpp"
#include "map_modules/feature_map/feature_map_settings.hpp"
#include "map_modules/feature_map/feature_observation.hpp"
#include "map_modules/feature_map/landmarks/landmark_store.hpp"

namespace waymark::feature_map {

/// Associates (association.hpp), refines the pose by every associated
/// detection in turn, and collects the log evidence of all observations and misses (docs/math/feature_map.md,
/// "Refinement and evidence").
template <int D>
void associate_and_refine(const LandmarkStore& store, const FeatureMapSettings& settings,
                          double mean_signature_distance, const PoseGaussian& prior,
                          const FeatureObservation& observation, FeatureAssociation& association, Refinement& out);

}  // namespace waymark::feature_map
