// SPDX-License-Identifier: Apache-2.0
// Grid maps of map_server: the first byte of an input says whether the rest is the YAML or the greymap.
#include <string>

#include "map_modules/occupancy_grid/map_file.hpp"
#include "plugins/shared/map_formats/map_server.hpp"
#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/input.hpp"

namespace waymark::fuzz::grid_map_harness {
namespace {
void run(std::string_view input) {
  const Choice choice = choose(input, 2);
  constexpr std::string_view kYaml =
      "image: room.pgm\nresolution: 0.1\norigin: [-1, -2, 0.5]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";
  constexpr std::string_view kImage("P5\n4 3\n255\n\0\xcd\xfe\xfe\0\xfe\xfe\xfe\0\0\xfe\xfe", 23);
  const auto yaml = write("room.yaml", choice.which == 0 ? choice.rest : kYaml);
  write("room.pgm", choice.which == 1 ? choice.rest : kImage);
  expect_value_or_error(
      [&] {
        const GridView grid = map_formats::read_map_server(yaml);
        if (grid.cells.size() != static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height))
          violation("a grid has not as many cells as its size says");
        if (!grid.T_map_grid.p.allFinite()) violation("the origin is not finite");
        (void)occupancy_grid::load_map_file(yaml, {.hit = 17, .miss = -8, .low = -40, .high = 70});
        (void)map_formats::greymap_text(grid);
      },
      folder().string());
}

const Harness kHarness("grid_map", run);

}  // namespace
}  // namespace waymark::fuzz::grid_map_harness
