// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/map_formats/map_server.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <vector>

#include "plugins/shared/map_formats/greymap.hpp"
#include "plugins/shared/map_formats/yaml_text.hpp"
#include "waymark/base/error.hpp"
#include "waymark/config/config.hpp"

namespace waymark::map_formats {

namespace {

/// The YAML of a map of `map_server` (ROS): which picture, where its cells lie, and what their pixels mean.
struct Legend {
  std::filesystem::path image;           ///< as in the YAML: relative to its folder
  double resolution_m = 0.0;             ///< side of a cell
  std::array<double, 3> origin_m_rad{};  ///< x, y [m] and yaw [rad] of the lower left corner of the picture
  bool negate = false;
  double occupied_above = 0.65;
  double free_below = 0.196;

  /// The percent of a pixel: below both thresholds free (0), above both occupied (100).
  std::uint8_t percent_of(std::uint8_t pixel, int white) const {
    const double light = static_cast<double>(pixel) / white;
    const double p = negate ? light : 1.0 - light;
    if (p > occupied_above) return 100;
    return p < free_below ? 0 : GridView::kUnknown;
  }
};

// Pixels and thresholds as map_server of ROS writes them (trinary): (255 - pixel) / 255 is the probability.
constexpr char kOccupiedPixel = '\0';
constexpr char kFreePixel = static_cast<char>(254);
constexpr char kUnknownPixel = static_cast<char>(205);
constexpr double kOccupiedThreshold = 0.65;
constexpr double kFreeThreshold = 0.196;

char pixel_of(std::uint8_t percent) {
  if (percent == GridView::kUnknown || percent == 50) return kUnknownPixel;
  return percent > 50 ? kOccupiedPixel : kFreePixel;
}

Legend read_legend(const Config& config) {
  Legend legend;
  legend.image = config.text({"image", "file of the picture, relative to the YAML"});
  legend.resolution_m = config.number_in({"resolution", "m", "side of a cell"}, 0.005, 10.0);
  const std::vector<double> origin =
      config.numbers({"origin", "m, m, rad", "x, y and yaw of the lower left corner of the picture"}, 3);
  constexpr double kFarthest = 1e8;  // beyond, doubles are too coarse for cells
  if (!(std::max(std::abs(origin[0]), std::abs(origin[1])) <= kFarthest)) {
    config.fail("origin", fmt::format("x {:g} m, y {:g} m; from -{:g} to {:g} is expected", origin[0], origin[1],
                                      kFarthest, kFarthest));
  }
  std::ranges::copy(origin, legend.origin_m_rad.begin());
  legend.negate =
      config.integer_in({"negate", "1: the lighter a pixel, the more probably its cell is occupied; 0: the darker"}, 0,
                        1, 0) == 1;
  legend.occupied_above =
      config.number_in({"occupied_thresh", "cells with a higher probability are occupied"}, 0.0, 1.0);
  legend.free_below = config.number_in({"free_thresh", "cells with a lower probability are free"}, 0.0, 1.0);
  config.choice({"mode", "`trinary`: cells are occupied, free or unknown"}, {"trinary"}, "trinary");
  if (legend.free_below > legend.occupied_above) config.fail("free_thresh", "must not exceed occupied_thresh");
  config.reject_unread();
  return legend;
}

/// An error names the line of the YAML that names the picture.
Greymap read_picture(const Config& config, const std::filesystem::path& image) {
  try {
    return read_greymap(image);
  } catch (const DataError& error) {
    config.fail("image", error.what());
  }
}

}  // namespace

GridView read_map_server(const std::filesystem::path& yaml) {
  const Config config = Config::load(yaml);
  const Legend legend = read_legend(config);
  const Greymap picture = read_picture(config, yaml.parent_path() / legend.image);
  GridView grid;
  grid.T_map_grid = Pose::planar(legend.origin_m_rad[0], legend.origin_m_rad[1], legend.origin_m_rad[2]);
  grid.resolution_m = legend.resolution_m;
  grid.width = picture.width;
  grid.height = picture.height;
  grid.cells.reserve(picture.pixels.size());
  for (int row = picture.height - 1; row >= 0; --row) {
    const auto begin = picture.pixels.begin() + static_cast<std::ptrdiff_t>(row) * picture.width;
    std::transform(begin, begin + picture.width, std::back_inserter(grid.cells),
                   [&](std::uint8_t pixel) { return legend.percent_of(pixel, picture.white); });
  }
  return grid;
}

std::string greymap_text(const GridView& grid) {
  std::string text = fmt::format("P5\n{} {}\n255\n", grid.width, grid.height);
  text.reserve(text.size() + grid.cells.size());
  for (int row = grid.height - 1; row >= 0; --row) {
    const auto begin = grid.cells.begin() + static_cast<std::ptrdiff_t>(row) * grid.width;
    std::transform(begin, begin + grid.width, std::back_inserter(text), pixel_of);
  }
  return text;
}

std::string legend_text(const GridView& grid, std::string_view image) {
  return fmt::format(
      "image: {}\nmode: trinary\nresolution: {}\norigin: [{}, {}, {}]\nnegate: 0\noccupied_thresh: {}\n"
      "free_thresh: {}\n",
      quoted_if_needed(image), grid.resolution_m, grid.T_map_grid.p.x(), grid.T_map_grid.p.y(), grid.T_map_grid.yaw(),
      kOccupiedThreshold, kFreeThreshold);
}

}  // namespace waymark::map_formats
