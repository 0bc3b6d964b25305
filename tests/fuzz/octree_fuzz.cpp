// SPDX-License-Identifier: Apache-2.0
// Octrees of OctoMap, .bt and .ot, as the command and the map module read them.
#include "apps/waymark/maps/conversion.hpp"
#include "apps/waymark/maps/octree_file.hpp"
#include "input.hpp"
#include "map_modules/octomap_grid/octomap_file.hpp"
#include "waymark/base/error.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace waymark;
  const auto file = fuzz::write("map.bt", fuzz::text_of(data, size));
  octomap_grid::OctomapGridSettings settings{};
  settings.resolution = 0.1;
  settings.odds = {.hit = 17, .miss = -8, .low = -40, .high = 70};
  fuzz::expect_value_or_error([&] { (void)octomap_grid::load_octomap(file, settings); }, file.string());
  fuzz::expect_value_or_error(
      [&] {
        const maps::LoadedOctree loaded = maps::read_octree(file);
        (void)maps::figures_of(*loaded.tree);
        try {
          (void)maps::slice_of(*loaded.tree, {0.0, 0.5});
        } catch (const Error&) {
          // about the slice, not about the file
        }
      },
      file.string());
  return 0;
}
