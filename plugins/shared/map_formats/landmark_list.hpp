// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "waymark/math/pose.hpp"

namespace waymark::map_formats {

/// The `version` of the format.
constexpr int kLandmarkListVersion = 1;

/// One landmark of a file: position and radius, how it looks, how sure it is that it is there.
struct LandmarkEntry {
  static constexpr std::size_t kMaxBins = 128;

  std::string place;             ///< "file:line:column"
  Eigen::Vector3d mean;          ///< east, north, radius [m]
  Eigen::Matrix3d P;             ///< of these
  Eigen::Matrix2d P_floor;       ///< of the position: what further sightings cannot remove
  std::vector<float> signature;  ///< adds up to 1; empty: not known
  std::int32_t signature_views = 0;
  std::int32_t identity = -1;  ///< negative: none
  std::optional<float> log_odds;
  std::optional<std::int32_t> sightings;
};

/// The landmarks of a feature map, or surveyed ones: YAML with `version: 1` and a list `landmarks`; of each, only
/// `east_m` and `north_m` must be there. All signatures have equally many bins. Throws ConfigError with file, line and
/// what was expected.
std::vector<LandmarkEntry> read_landmark_list(const std::filesystem::path& file);

/// The landmarks as such a file, one a line.
std::string landmark_list_text(const std::vector<LandmarkEntry>& landmarks);

/// Moves a landmark and turns its covariances. The pose is planar; its height does not count.
void move_landmark(const Pose& T_to_from, LandmarkEntry& landmark);

}  // namespace waymark::map_formats
