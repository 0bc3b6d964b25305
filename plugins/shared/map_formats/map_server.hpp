// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "waymark/interface/map_view.hpp"

namespace waymark::map_formats {

/// YAML and picture: every cell is 0, 100 or unknown, `T_map_grid` may be turned. Throws ConfigError with the file, the
/// line, the value and what was expected.
GridView read_map_server(const std::filesystem::path& yaml);

/// The picture of a grid, a binary greymap, rows from the top: black is occupied (probability above ½), 254 free (below
/// ½), 205 unknown, or exactly ½.
std::string greymap_text(const GridView& grid);

/// The YAML that belongs to `greymap_text`, which is kept in the file `image` beside it.
std::string legend_text(const GridView& grid, std::string_view image);

}  // namespace waymark::map_formats
