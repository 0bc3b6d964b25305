// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>

#include "waymark/base/api.hpp"
#include "waymark/interface/map_module.hpp"

namespace waymark::particles {

/// A particle's map seen from above, and the weight of the particle.
struct WeightedGrid {
  GridView grid;
  double weight;
};

/// What all particles make of each cell: which share of the weight of those that know the cell takes it for occupied
/// (above ½), in percent. 0 and 100 are kept for cells in which they agree. The grids' cells must lie in one lattice,
/// as those of particles of one map do. Throws Error if they do not, or if the whole were too large.
WAYMARK_API std::optional<GridView> mix_grids(std::span<const WeightedGrid> grids);

}  // namespace waymark::particles
