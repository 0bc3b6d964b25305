// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/map_formats/load_settings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string>
#include <system_error>
#include <vector>

#include "plugins/shared/map_formats/map_manifest.hpp"
#include "waymark/io/file_stems.hpp"

namespace waymark::map_formats {

namespace {

/// The layer of a map: that of its name, else the only one of its format.
const MapLayer& layer_for(const MapManifest& manifest, const Config& config, std::string_view format) {
  const std::string name = config.has("name") ? config.text("name") : std::string();
  if (const MapLayer* layer = manifest.find(name)) {
    if (layer->format != format) {
      config.fail("load", fmt::format("{}: its layer \"{}\" is of the format {}; {} is expected",
                                      manifest.file.string(), name, layer->format, format));
    }
    return *layer;
  }
  std::vector<std::string> fitting;
  const MapLayer* only = nullptr;
  for (const MapLayer& layer : manifest.layers) {
    if (layer.format != format) continue;
    fitting.push_back(layer.name);
    only = &layer;
  }
  if (fitting.size() == 1) return *only;
  config.fail("load",
              fmt::format("{}: it has no layer \"{}\", and {} of the format {}{}; the name of one, or one alone, "
                          "is expected",
                          manifest.file.string(), name, fitting.empty() ? "none" : "several", format,
                          fitting.empty() ? "" : fmt::format(" ({})", fmt::join(fitting, ", "))));
}

void place(const MapManifest& manifest, const MapLayer& layer, LoadSettings& settings) {
  settings.file = layer.file;
  settings.T_map_file = layer.T_frame_file;
  std::error_code ignored;
  const std::filesystem::path whole = std::filesystem::weakly_canonical(manifest.file, ignored);
  settings.frame = MapFrame{whole.empty() ? manifest.file.string() : whole.string(), manifest.datum};
}

/// A layer of a run that is loaded without its manifest: it still lies where that says.
void place_by_neighbour(LoadSettings& settings) {
  const std::filesystem::path beside = settings.file.parent_path() / kMapManifestFile;
  std::error_code ignored;
  if (!std::filesystem::exists(beside, ignored) || !is_manifest(beside)) return;
  const MapManifest manifest = read_manifest(beside);
  const auto stem_of = [](const std::filesystem::path& file) { return file.parent_path() / file.stem(); };
  for (const MapLayer& layer : manifest.layers) {
    // An octree is written in two formats, of which the manifest names one.
    if (layer.format != layer_format(settings.file) || stem_of(layer.file) != stem_of(settings.file)) continue;
    const std::filesystem::path file = settings.file;
    place(manifest, layer, settings);
    settings.file = file;
    return;
  }
}

}  // namespace

LoadSettings LoadSettings::read(const Config& config, std::string_view format) {
  LoadSettings s;
  const std::string mode = config.choice(
      {"mode", "`map`: a new map; with `load`: `continue` (the map is updated) or `localize` (it stays as it is)"},
      {"map", "continue", "localize"}, "map");
  s.use = mode == "map" ? MapUse::map : mode == "continue" ? MapUse::continue_map : MapUse::localize;
  if (config.has("load")) {
    const std::string file =
        config.text({"load", "",
                     "a prior map, relative to the YAML: the `maps.yaml` of a run, or one file: a YAML of `map_server` "
                     "(occupancy_grid), a `.bt` or `.ot` (octomap_grid), a `.landmarks.yaml` (feature_map)",
                     "none"});
    if (file.empty()) config.fail("load", "is empty; the file of a map is expected");
    s.file = config.file().parent_path() / file;
  }
  if (s.use == MapUse::map && !s.file.empty()) config.fail("mode", "must be continue or localize for a loaded map");
  if (s.use != MapUse::map && s.file.empty()) config.fail("mode", "continue and localize need a map: load");
  if (s.file.empty()) return s;
  if (is_manifest(s.file)) {
    const MapManifest manifest = read_manifest(s.file);
    place(manifest, layer_for(manifest, config, format), s);
  } else {
    place_by_neighbour(s);
  }
  return s;
}

}  // namespace waymark::map_formats
