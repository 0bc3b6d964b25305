// SPDX-License-Identifier: Apache-2.0
// Octrees of OctoMap, .bt and .ot, as the command and the map module read them.
#include "apps/waymark/maps/conversion.hpp"
#include "apps/waymark/maps/octree_file.hpp"
#include "map_modules/octomap_grid/octomap_file.hpp"
#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/input.hpp"
#include "waymark/base/error.hpp"

namespace waymark::fuzz::octree_harness {
namespace {
void run(std::string_view input) {
  const auto file = write("map.bt", input);
  octomap_grid::OctomapGridSettings settings{};
  settings.resolution = 0.1;
  settings.odds = {.hit = 17, .miss = -8, .low = -40, .high = 70};
  expect_value_or_error([&] { (void)octomap_grid::load_octomap(file, settings); }, file.string());
  expect_value_or_error(
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
}

const Harness kHarness("octree", run);

}  // namespace
}  // namespace waymark::fuzz::octree_harness
