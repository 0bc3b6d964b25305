// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "greymap.hpp"
#include "waymark/map_module.hpp"

namespace waymark::map_formats {

enum class CellState : std::uint8_t { unknown, free, occupied };

/// The YAML of a map of `map_server` (ROS): which picture, where its cells lie, and what their pixels mean.
struct Legend {
  std::filesystem::path image;           ///< as the YAML says: relative to its folder
  double resolution_m = 0.0;             ///< side of a cell
  std::array<double, 3> origin_m_rad{};  ///< x, y [m] and yaw [rad] of the lower left corner of the picture
  bool negate = false;
  double occupied_above = 0.65;
  double free_below = 0.196;

  /// What a pixel says: below both thresholds free, above both occupied.
  CellState state_of(std::uint8_t pixel, int white) const {
    const double light = static_cast<double>(pixel) / white;
    const double p = negate ? light : 1.0 - light;
    if (p > occupied_above) return CellState::occupied;
    return p < free_below ? CellState::free : CellState::unknown;
  }
};

/// Throws ConfigError with the file, the line, the value and what was expected.
Legend read_legend(const std::filesystem::path& yaml);

/// YAML and picture: every cell is 0, 100 or unknown. Throws ConfigError or DataError.
GridView read_map_server(const std::filesystem::path& yaml);

/// The picture of a grid, a binary greymap, rows from the top: black is occupied (probability above ½), 254 free (below
/// ½), 205 unknown, or exactly ½.
std::string greymap_text(const GridView& grid);

/// The YAML that belongs to `greymap_text`, which is kept in the file `image` beside it.
std::string legend_text(const GridView& grid, std::string_view image);

}  // namespace waymark::map_formats
