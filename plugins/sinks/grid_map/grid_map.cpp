// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <string>

#include "waymark/output_file.hpp"
#include "waymark/plugin.hpp"

namespace waymark {
namespace {

// Pixels and thresholds as map_server of ROS writes them (trinary): (255 - pixel) / 255 is the probability.
constexpr char kOccupied = '\0';
constexpr char kFree = static_cast<char>(254);
constexpr char kUnknown = static_cast<char>(205);
constexpr double kOccupiedThreshold = 0.65;
constexpr double kFreeThreshold = 0.196;

char pixel_of(std::uint8_t percent) {
  if (percent == GridView::kUnknown || percent == 50) return kUnknown;
  return percent > 50 ? kOccupied : kFree;
}

/// A binary greymap, P5: rows from the top.
std::string pgm(const GridView& grid) {
  std::string text = fmt::format("P5\n{} {}\n255\n", grid.width, grid.height);
  text.reserve(text.size() + grid.cells.size());
  for (int row = grid.height - 1; row >= 0; --row) {
    const auto begin = grid.cells.begin() + static_cast<std::ptrdiff_t>(row) * grid.width;
    std::transform(begin, begin + grid.width, std::back_inserter(text), pixel_of);
  }
  return text;
}

std::string yaml(const GridView& grid, std::string_view image) {
  return fmt::format(
      "image: {}\nmode: trinary\nresolution: {}\norigin: [{}, {}, {}]\nnegate: 0\noccupied_thresh: {}\n"
      "free_thresh: {}\n",
      image, grid.resolution_m, grid.T_map_grid.p.x(), grid.T_map_grid.p.y(), grid.T_map_grid.yaw(), kOccupiedThreshold,
      kFreeThreshold);
}

/// What a map is called in the YAML, as a file name.
std::string file_stem(std::string name) {
  for (char& c : name) {
    const bool is_plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-';
    if (!is_plain) c = '_';
  }
  return name;
}

/// The best particle's dense maps as map_server of ROS reads them, at the end of the run.
class GridMap : public Sink {
 public:
  explicit GridMap(const Config&) {}

  void start(const RunInfo& info) override { out_dir_ = info.out_dir; }
  void write(const Snapshot&) override {}

  void finish(const Snapshot* last, const RunReport&) override {
    if (last == nullptr || !last->started()) return;
    for (const MapDescription& map : last->best_maps(MapDetail::with_grids)) {
      if (!map.grid) continue;
      const std::string stem = file_stem(map.module);
      write_file(out_dir_ / (stem + ".pgm"), pgm(*map.grid));
      write_file(out_dir_ / (stem + ".yaml"), yaml(*map.grid, stem + ".pgm"));
    }
  }

 private:
  std::filesystem::path out_dir_;
};

}  // namespace
}  // namespace waymark

WAYMARK_PLUGIN(waymark::Sink, waymark::GridMap, "grid_map", "1.0.0")
