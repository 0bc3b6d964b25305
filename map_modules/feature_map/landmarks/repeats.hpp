// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "map_modules/feature_map/feature_map_settings.hpp"
#include "waymark/base/time.hpp"

namespace waymark::feature_map {

/// How much of a detection's information the one before, of the same landmark, has not given yet, in (0, 1]. Errors of
/// a device that measures a landmark again repeat themselves: of a chain x⁺ = ρ x + noise with ρ = exp(−Δt/τ), every
/// value after the first says (1 − ρ)/(1 + ρ) = tanh(Δt/2τ) times as much about a constant as an independent one would.
inline double new_share(const DetectionNoise& noise, Time last_seen, Time stamp) {
  constexpr double kLeast = 1e-6;  // two measurements of one stamp
  if (noise.correlation == 0.0 || last_seen == Time{}) return 1.0;
  return std::max(kLeast, std::tanh(0.5 * std::abs(to_seconds(stamp - last_seen)) / noise.correlation));
}

}  // namespace waymark::feature_map
