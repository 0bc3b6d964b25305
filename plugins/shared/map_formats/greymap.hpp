// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace waymark::map_formats {

/// The pixels of a binary greymap (PGM, P5, one byte a pixel), rows from the top.
struct Greymap {
  int width = 0;
  int height = 0;
  int white = 255;  ///< the largest value
  std::vector<std::uint8_t> pixels;
};

/// Throws DataError: no such file, no such format, larger than a map can be, or more or fewer pixels than its header
/// claims.
Greymap read_greymap(const std::filesystem::path& file);

}  // namespace waymark::map_formats
