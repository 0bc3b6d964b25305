// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/map_formats/write_maps.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "plugins/shared/map_formats/map_manifest.hpp"
#include "plugins/shared/map_formats/map_server.hpp"

namespace waymark::map_formats {

void write_maps(const Snapshot& last, const std::filesystem::path& folder, FileStems stems, Belongs belongs) {
  MapManifest manifest{folder / kMapManifestFile, last.datum(), {}};
  const std::vector<MapDescription> maps = last.best_maps(MapDetail::with_files);
  const bool has_grids = std::ranges::any_of(maps, [](const MapDescription& map) { return map.files.empty(); });
  const std::vector<MapDescription> with_grids =
      has_grids ? last.best_maps(MapDetail::with_grids) : std::vector<MapDescription>(maps.size());
  for (std::size_t i = 0; i < maps.size(); ++i) {
    const std::string stem = stems.of(maps[i].module);
    MapLayer layer;
    for (const MapFile& file : maps[i].files) {
      // Of several formats the last one says the most.
      layer = {maps[i].module, {}, folder / (stem + file.extension), file.T_enu_file};
      write_file(layer.file, file.content, belongs);
    }
    if (const auto& grid = with_grids[i].grid; maps[i].files.empty() && grid) {
      layer = {maps[i].module, {}, folder / (stem + ".yaml"), {}};
      write_file(folder / (stem + ".pgm"), greymap_text(*grid), belongs);
      write_file(layer.file, legend_text(*grid, stem + ".pgm"), belongs);
    }
    if (layer.file.empty()) continue;
    layer.format = layer_format(layer.file);
    manifest.layers.push_back(std::move(layer));
  }
  if (!manifest.layers.empty()) write_file(manifest.file, manifest_text(manifest, folder), belongs);
}

}  // namespace waymark::map_formats
