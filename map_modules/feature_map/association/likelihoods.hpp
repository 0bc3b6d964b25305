// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "map_modules/feature_map/feature_map_settings.hpp"
#include "map_modules/feature_map/signature.hpp"

/// What a detection is compared by, beside its place: signatures, and the new landmark that it may be.
namespace waymark::feature_map {

/// D of (4.7), 1 − Σ √(a b): the squared Hellinger distance, 0..1.
double signature_distance(const Signature& a, const Signature& b);
double signature_distance(const Signature& a, std::span<const float> b);

/// D of a landmark that is none of the map's: as configured, or else the mean that was learnt.
double new_landmark_signature_distance(const FeatureMapSettings& settings, double mean_signature_distance);

/// log of the new-landmark likelihood p₀: a density over the observation's space.
double log_new_landmark(const FeatureMapSettings& settings, double mean_signature_distance);

/// log p_v of (4.7), −λ D; 0 where the map uses no signatures. If the detection's or the landmark's signature is
/// unknown, D is that of a new landmark, so that the pair is neither likelier nor less likely for it.
double log_signature_likelihood(const FeatureMapSettings& settings, const Signature& detection,
                                std::span<const float> landmark, double distance_of_new);

}  // namespace waymark::feature_map
