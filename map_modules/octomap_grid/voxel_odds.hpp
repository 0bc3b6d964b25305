// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "map_modules/shared/scan_matching/scan_settings.hpp"

namespace waymark::octomap_grid {

/// What all of a map's voxels are updated by: natural log-odds.
struct VoxelOdds {
  explicit VoxelOdds(const scan_matching::OddsSettings& s)
      : hit(static_cast<float>(s.hit / scan_matching::OddsSettings::kSteps)),
        miss(static_cast<float>(s.miss / scan_matching::OddsSettings::kSteps)),
        low(static_cast<float>(s.low / scan_matching::OddsSettings::kSteps)),
        high(static_cast<float>(s.high / scan_matching::OddsSettings::kSteps)) {}
  float after_hit(float odds) const { return odds + hit < high ? odds + hit : high; }
  float after_miss(float odds) const { return odds + miss > low ? odds + miss : low; }

  float hit;
  float miss;
  float low;
  float high;
};

inline bool is_occupied(float odds) { return odds > 0.0f; }

}  // namespace waymark::octomap_grid
