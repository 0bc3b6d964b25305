// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "wire.hpp"

namespace waymark::rosbag1 {

/// What came out of compressed bytes, as far as it goes.
struct Decompressed {
  std::vector<std::uint8_t> bytes;
  std::string problem;  ///< why there is no more; empty: it is whole
};

/// True for "none", "bz2" and "lz4".
bool knows_compression(std::string_view name);

/// Undoes the compression; `size` bytes are expected.
Decompressed decompress(std::string_view compression, Bytes stored, std::size_t size);

}  // namespace waymark::rosbag1
