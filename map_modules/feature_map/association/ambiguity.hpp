// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "map_modules/feature_map/association/feature_association.hpp"
#include "map_modules/feature_map/feature_map_settings.hpp"
#include "map_modules/feature_map/feature_observation.hpp"
#include "waymark/math/pose.hpp"

namespace waymark::feature_map {

/// How likely an associated detection is with its landmark and with the likeliest other one, as log likelihoods.
struct Rivals {
  double chosen;
  double other;
};

/// By the likelihoods of `association.pairs`, at least `least` each.
Rivals rivals_of(std::size_t detection, const FeatureAssociation& association, double least);

/// Counts associated detections, and those of them that nearly had another landmark or none, of log likelihood
/// `log_p0`.
void count_ambiguous(double log_p0, FeatureAssociation& association);

/// A detection that fits no landmark but lies closer to one than two landmarks can stand is an outlier of that one, a
/// double echo, or a glimpse of its neighbour: a new landmark there would compete with the old one from now on. It
/// becomes ambiguous. Nor does a candidate make a landmark that the camera has not confirmed.
void reject_doubtful_new(const FeatureMapSettings& settings, const Pose& T_map_base,
                         const FeatureObservation& observation, FeatureAssociation& association);

}  // namespace waymark::feature_map
