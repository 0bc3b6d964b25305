// SPDX-License-Identifier: Apache-2.0
// Lists of landmarks as YAML.
#include <cmath>

#include "input.hpp"
#include "plugins/shared/map_formats/landmark_list.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace waymark;
  const auto file = fuzz::write("map.landmarks.yaml", fuzz::text_of(data, size));
  fuzz::expect_value_or_error(
      [&] {
        for (const map_formats::LandmarkEntry& entry : map_formats::read_landmark_list(file)) {
          if (!entry.mean.allFinite() || !entry.P.allFinite() || !entry.P_floor.allFinite())
            fuzz::violation("a landmark has numbers that are not finite");
          if (entry.log_odds && !std::isfinite(*entry.log_odds)) fuzz::violation("log-odds are not finite");
        }
      },
      file.string());
  return 0;
}
