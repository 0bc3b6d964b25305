// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/association/likelihoods.hpp"

#include <algorithm>
#include <cmath>

namespace waymark::feature_map {

double signature_distance(const Signature& a, const Signature& b) {
  return signature_distance(a, std::span<const float>(b.begin(), b.size()));
}

double signature_distance(const Signature& a, std::span<const float> b) {
  double overlap = 0.0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    overlap += std::sqrt(static_cast<double>(a[i]) * static_cast<double>(b[i]));
  return std::max(0.0, 1.0 - overlap);
}

double new_landmark_signature_distance(const FeatureMapSettings& settings, double mean_signature_distance) {
  const double fixed = settings.association.new_landmark_signature_distance;
  return std::isfinite(fixed) ? fixed : mean_signature_distance;
}

double log_new_landmark(const FeatureMapSettings& settings, double mean_signature_distance) {
  double log_p0 = std::log(settings.association.new_landmark_density);
  if (settings.use_radius) log_p0 -= std::log(settings.association.radius_range);
  if (settings.use_signature) {
    log_p0 -=
        settings.association.signature_lambda * new_landmark_signature_distance(settings, mean_signature_distance);
  }
  return log_p0;
}

double log_signature_likelihood(const FeatureMapSettings& settings, const Signature& detection,
                                std::span<const float> landmark, double distance_of_new) {
  if (!settings.use_signature) return 0.0;
  const bool unknown = detection.empty() || landmark.empty();
  return -settings.association.signature_lambda * (unknown ? distance_of_new : signature_distance(detection, landmark));
}

}  // namespace waymark::feature_map
