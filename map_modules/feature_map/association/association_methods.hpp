// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "map_modules/feature_map/association/feature_association.hpp"

/// Ways to choose among the pairs of detections and landmarks in `association.pairs`, all of them within the gate and
/// likelier than a new landmark. Each fills `association.landmark_of` and the marks `taken`.
namespace waymark::feature_map {

/// The most likely pair first (4.8).
void associate_greedily(FeatureAssociation& association);

/// The greatest sum of log likelihoods, with `log_p0` for every detection without a landmark. Detections that compete
/// for no common landmark, directly or through others, are solved apart.
void associate_optimally(double log_p0, FeatureAssociation& association);

}  // namespace waymark::feature_map
