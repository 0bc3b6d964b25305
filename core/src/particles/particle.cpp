// SPDX-License-Identifier: Apache-2.0
#include "particles/particle.hpp"

namespace waymark::particles {

Particle Particle::clone() const {
  Particle copy{belief, log_weight, {}, path, anchors, T_map_mapped};
  copy.maps.reserve(maps.size());
  for (const auto& map : maps) copy.maps.push_back(map ? map->clone() : nullptr);
  return copy;
}

Gates::Gates(double probability) {
  for (int rows = 1; rows <= kMaxUpdateRows; ++rows) {
    quantiles_[static_cast<std::size_t>(rows)] = gaussian::chi_squared_quantile(probability, rows);
  }
}

}  // namespace waymark::particles
