// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "waymark/base/api.hpp"

namespace waymark::particles {

/// Normalises log weights in place so that Σ exp = 1. If the sum is not finite (all are -inf: no particle explains the
/// data) they become equal; returns false then.
WAYMARK_API bool normalize_log_weights(std::span<double> log_weights);

/// N_eff = 1 / Σ w², of normalised log weights; between 1 and their number.
WAYMARK_API double effective_sample_size(std::span<const double> log_weights);

/// Systematic (low-variance) resampling (Carpenter, Clifford, Fearnhead, 1999): ancestor of every new slot, ascending.
/// A particle of weight w gets floor(M w) or ceil(M w) children. `u` is uniform in (0, 1).
WAYMARK_API std::vector<int> systematic_resample(std::span<const double> log_weights, double u);

}  // namespace waymark::particles
