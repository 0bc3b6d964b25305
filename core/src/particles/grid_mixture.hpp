// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>

#include "waymark/base/api.hpp"
#include "waymark/interface/particle_map.hpp"

namespace waymark::particles {

/// A particle's map seen from above, and the weight of the particle.
struct WeightedGrid {
  GridView grid;
  double weight;
};

/// Mixture of the particles' grids. A cell is the weight of the particles that have it occupied (above ½) over the
/// weight of those that have it known, in percent; 0 and 100 only if all of these agree. The cells must lie in one
/// lattice, as those of one map module do. Throws Error if they do not, or if the result would be too large.
WAYMARK_API std::optional<GridView> mix_grids(std::span<const WeightedGrid> grids);

}  // namespace waymark::particles
