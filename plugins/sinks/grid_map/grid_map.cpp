// SPDX-License-Identifier: Apache-2.0
#include <string>

#include "plugins/shared/map_formats/map_server.hpp"
#include "waymark/io/file_stems.hpp"
#include "waymark/io/output_file.hpp"
#include "waymark/plugin/sink.hpp"

namespace waymark::grid_map {
namespace {

/// The best particle's dense maps as map_server of ROS reads them, at the end of the run.
class GridMap : public Sink {
 public:
  explicit GridMap(const Config&) {}

  void start(const RunInfo& info) override { out_dir_ = info.out_dir; }
  void write(const Snapshot&) override {}

  void finish(const Snapshot* last, const RunReport&) override {
    if (last == nullptr || !last->started()) return;
    FileStems stems = FileStems::of_results();
    for (const MapDescription& map : last->best_maps(MapDetail::with_grids)) {
      const std::string stem = stems.of(map.module);
      if (!map.grid) continue;
      write_file(out_dir_ / (stem + ".pgm"), map_formats::greymap_text(*map.grid));
      write_file(out_dir_ / (stem + ".yaml"), map_formats::legend_text(*map.grid, stem + ".pgm"));
    }
  }

 private:
  std::filesystem::path out_dir_;
};

}  // namespace
}  // namespace waymark::grid_map

WAYMARK_PLUGIN(waymark::Sink, waymark::grid_map::GridMap, "grid_map", "1.0.0")
