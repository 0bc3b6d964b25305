// SPDX-License-Identifier: Apache-2.0
#include "layered_map.hpp"

#include <fmt/format.h>

#include <utility>

#include "plugins/shared/map_formats/map_manifest.hpp"
#include "plugins/shared/map_formats/map_server.hpp"
#include "plugins/shared/map_formats/octree_text.hpp"
#include "waymark/base/error.hpp"
#include "waymark/io/file_stems.hpp"
#include "waymark/io/output_file.hpp"

namespace waymark::maps {

namespace {

Layer read_layer(const map_formats::MapLayer& named) {
  Layer layer{named.name, {}, {}};
  if (named.format == map_formats::kLandmarksFormat) {
    Landmarks landmarks = map_formats::read_landmark_list(named.file);
    for (map_formats::LandmarkEntry& landmark : landmarks) map_formats::move_landmark(named.T_frame_file, landmark);
    layer.content = std::move(landmarks);
  } else if (named.format == map_formats::kMapServerFormat) {
    GridView grid = map_formats::read_map_server(named.file);
    grid.T_map_grid = named.T_frame_file * grid.T_map_grid;
    layer.content = std::move(grid);
  } else if (named.format == map_formats::kOctreeFormat) {
    layer.content = read_octree(named.file);
    layer.T_frame_file = named.T_frame_file;
  } else {
    throw Error(fmt::format("{}: the format {} is not known; landmarks, map_server or octree is expected",
                            named.file.string(), named.format));
  }
  return layer;
}

/// Writes one layer; `stem` is the file without its extension.
std::filesystem::path write_layer(Layer& layer, const std::string& stem, std::vector<std::filesystem::path>& written) {
  const auto write = [&](const std::string& file, const std::string& content) {
    write_file(file, content, Belongs::to_nobody);
    written.emplace_back(file);
  };
  if (const auto* landmarks = std::get_if<Landmarks>(&layer.content)) {
    write(stem + ".landmarks.yaml", map_formats::landmark_list_text(*landmarks));
    return written.back();
  }
  if (const auto* grid = std::get_if<GridView>(&layer.content)) {
    write(stem + ".pgm", map_formats::greymap_text(*grid));
    write(stem + ".yaml", map_formats::legend_text(*grid, std::filesystem::path(stem).filename().string() + ".pgm"));
    return written.back();
  }
  auto& octree = std::get<LoadedOctree>(layer.content);
  const bool is_full = octree.format == map_formats::OctreeFormat::full;
  write(stem + (is_full ? ".ot" : ".bt"), map_formats::octree_text(*octree.tree, octree.format));
  return written.back();
}

/// The name of a file without what `write_layer` adds. Throws Error if that is something else.
std::string stem_for(const Layer& layer, const std::filesystem::path& out) {
  const auto without = [&](std::string_view extension) {
    const std::string name = out.string();
    if (!name.ends_with(extension)) throw Error(fmt::format("{}: a name that ends in {} is expected", name, extension));
    return name.substr(0, name.size() - extension.size());
  };
  if (std::holds_alternative<Landmarks>(layer.content)) return without(".landmarks.yaml");
  if (std::holds_alternative<GridView>(layer.content)) return without(".yaml");
  return without(std::get<LoadedOctree>(layer.content).format == map_formats::OctreeFormat::full ? ".ot" : ".bt");
}

}  // namespace

LayeredMap read_layered_map(const std::filesystem::path& file) {
  LayeredMap map;
  if (map_formats::is_manifest(file)) {
    const map_formats::MapManifest manifest = map_formats::read_manifest(file);
    map.datum = manifest.datum;
    map.is_manifest = true;
    map.layers.reserve(manifest.layers.size());
    for (const map_formats::MapLayer& layer : manifest.layers) map.layers.push_back(read_layer(layer));
    return map;
  }
  map.layers.push_back(read_layer({file.stem().string(), map_formats::layer_format(file), file, {}}));
  return map;
}

std::vector<std::filesystem::path> write_layered_map(LayeredMap map, const std::filesystem::path& out) {
  std::vector<std::filesystem::path> written;
  if (!map.is_manifest) {
    write_layer(map.layers.front(), stem_for(map.layers.front(), out), written);
    return written;
  }
  if (out.extension() != ".yaml")
    throw Error(fmt::format("{}: a name that ends in .yaml is expected, that of a manifest", out.string()));
  const std::filesystem::path folder = out.parent_path();
  if (!folder.empty()) create_folder(folder);
  FileStems stems({out.stem().string()});
  map_formats::MapManifest manifest{out, map.datum, {}};
  for (Layer& layer : map.layers) {
    const std::filesystem::path file = write_layer(layer, (folder / stems.of(layer.name)).string(), written);
    manifest.layers.push_back({layer.name, map_formats::layer_format(file), file, layer.T_frame_file});
  }
  write_file(out, map_formats::manifest_text(manifest, folder), Belongs::to_nobody);
  written.push_back(out);
  return written;
}

}  // namespace waymark::maps
