// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "map_modules/feature_map/feature_map_settings.hpp"
#include "map_modules/feature_map/landmarks/landmark_store.hpp"

namespace waymark::feature_map {

/// What `merge_neighbours` did.
struct MergeCounts {
  int merged = 0;     ///< landmarks that went into another one
  int confirmed = 0;  ///< provisional landmarks that became confirmed by it
};

/// Merges landmarks that have come closer than `association.min_separation` to one of `written` and agree with it
/// within the gate: they are one thing that was taken for two. `written` are the landmarks that were associated in this
/// step (places with a negative chunk are skipped); two of them never merge, for they were seen at the same time, and
/// neither do two with different identities. Refs of other landmarks stay valid.
MergeCounts merge_neighbours(LandmarkStore& store, const FeatureMapSettings& settings,
                             std::span<const LandmarkRef> written);

}  // namespace waymark::feature_map
