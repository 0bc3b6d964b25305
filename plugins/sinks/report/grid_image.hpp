// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "waymark/interface/particle_map.hpp"

namespace waymark::report {

/// A grid as a picture.
struct GridImage {
  std::string png_base64;  ///< grey: light is free, dark occupied; unknown cells are transparent. First row: north
  double width_m = 0.0;
  double height_m = 0.0;
};

/// Of a large grid several cells are one pixel: the picture has at most 2000 × 2000. Throws Error if it cannot be
/// encoded.
GridImage picture_of(const GridView& grid);

}  // namespace waymark::report
