// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "estimation/georeference.hpp"
#include "waymark/base/api.hpp"
#include "waymark/interface/nav_state.hpp"

namespace waymark::estimation {

/// False if a variance of the belief is not finite, negative by more than rounding, or that of a pose anywhere on the
/// Earth and beyond (σ of 10⁸ m). Costs one look at the diagonal.
WAYMARK_API bool has_plausible_variances(const Belief& belief);

/// True if the belief can be updated: finite, with plausible variances, and a positive definite covariance (up to
/// rounding, and to states without variance).
WAYMARK_API bool is_sound(const Belief& belief);

/// A pose from which a belief begins anew.
struct NewStart {
  Belief prior;             ///< pose (in ENU) and twist with their covariance, at the time of the start
  bool keeps_pose = false;  ///< the mean of the pose stays; covariance and twist are those of the prior
};

/// Begins `belief` anew at the stamp of `start`: pose and twist are those of `start`, uncorrelated with what was
/// before. The own states of sensors, and the map's place on the Earth, keep their values; their variances grow as
/// predicted, but not beyond those of the first start. If the belief was not sound, what is not plausible begins anew,
/// too.
WAYMARK_API void begin_anew(Belief& belief, const NewStart& start, const StateLayout& layout,
                            const std::optional<Georeference>& georeference);

}  // namespace waymark::estimation
