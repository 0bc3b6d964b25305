// SPDX-License-Identifier: Apache-2.0
// Manifests of maps, and what the command makes of them with their layers.
#include "apps/waymark/maps/map_edits.hpp"
#include "plugins/shared/map_formats/map_manifest.hpp"
#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/input.hpp"

namespace waymark::fuzz::map_manifest_harness {
namespace {
void run(std::string_view input) {
  const auto file = write("maps.yaml", input);
  write("a.landmarks.yaml", "version: 1\nlandmarks:\n  - { east_m: 1, north_m: 2 }\n");
  write("a.yaml",
        "image: a.pgm\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n");
  write("a.pgm", std::string_view("P5\n2 1\n255\n\0\xfe", 13));
  expect_value_or_error(
      [&] {
        const map_formats::MapManifest manifest = map_formats::read_manifest(file);
        for (const map_formats::MapLayer& layer : manifest.layers) {
          if (!layer.T_frame_file.p.allFinite()) violation("a pose is not finite");
          if (layer.name.empty() || layer.file.empty()) violation("a layer has no name or no file");
        }
        const auto again = write("again.yaml", map_formats::manifest_text(manifest, file.parent_path()));
        if (map_formats::read_manifest(again).layers.size() != manifest.layers.size())
          violation("a manifest that was written is not read as the same");
        // Elsewhere a layer may be any file of this machine.
        for (const map_formats::MapLayer& layer : manifest.layers) {
          if (layer.file.lexically_normal().parent_path() != file.parent_path()) return;
        }
        maps::LayeredMap map = maps::read_layered_map(file);
        maps::crop(map, {0.0, 0.0, 2.0, 3.0});
      },
      folder().string());
}

const Harness kHarness("map_manifest", run);

}  // namespace
}  // namespace waymark::fuzz::map_manifest_harness
