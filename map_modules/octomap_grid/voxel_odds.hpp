// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "scan_settings.hpp"

namespace waymark::octo {

/// What all of a map's voxels are updated by: natural log-odds.
struct VoxelOdds {
  explicit VoxelOdds(const grid::OddsSettings& s)
      : hit(static_cast<float>(s.hit / grid::OddsSettings::kSteps)),
        miss(static_cast<float>(s.miss / grid::OddsSettings::kSteps)),
        low(static_cast<float>(s.low / grid::OddsSettings::kSteps)),
        high(static_cast<float>(s.high / grid::OddsSettings::kSteps)) {}
  float after_hit(float odds) const { return odds + hit < high ? odds + hit : high; }
  float after_miss(float odds) const { return odds + miss > low ? odds + miss : low; }

  float hit;
  float miss;
  float low;
  float high;
};

inline bool is_occupied(float odds) { return odds > 0.0f; }

}  // namespace waymark::octo
