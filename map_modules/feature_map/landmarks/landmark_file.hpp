// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "map_modules/feature_map/feature_map_settings.hpp"
#include "map_modules/feature_map/landmarks/landmark_store.hpp"
#include "waymark/math/pose.hpp"

namespace waymark::feature_map {

/// All landmarks as YAML, one a line, that `read_landmark_file` reads. `T_enu_map` is where the map lies (planar); its
/// own uncertainty is not written.
std::string landmark_file(const LandmarkStore& landmarks, const Pose& T_enu_map);

/// Landmarks that `landmark_file` wrote, or that were surveyed: of each, only `east_m` and `north_m` must be there.
/// Throws ConfigError with file, line and what was expected.
LandmarkStore read_landmark_file(const std::filesystem::path& file, const FeatureMapSettings& settings);

}  // namespace waymark::feature_map
