// SPDX-License-Identifier: Apache-2.0
// Lists of landmarks as YAML.
#include <cmath>

#include "plugins/shared/map_formats/landmark_list.hpp"
#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/input.hpp"

namespace waymark::fuzz::landmarks_harness {
namespace {
void run(std::string_view input) {
  const auto file = write("map.landmarks.yaml", input);
  expect_value_or_error(
      [&] {
        for (const map_formats::LandmarkEntry& entry : map_formats::read_landmark_list(file)) {
          if (!entry.mean.allFinite() || !entry.P.allFinite() || !entry.P_floor.allFinite())
            violation("a landmark has numbers that are not finite");
          if (entry.log_odds && !std::isfinite(*entry.log_odds)) violation("log-odds are not finite");
        }
      },
      file.string());
}

const Harness kHarness("landmarks", run);

}  // namespace
}  // namespace waymark::fuzz::landmarks_harness
