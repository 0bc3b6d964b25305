// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "plugins/shared/compression/decompressed.hpp"

namespace waymark::compression {

/// One frame of Zstandard with a checksum. `level`: 1 (fast) to 19 (small).
std::vector<std::uint8_t> compress_zstd(std::span<const std::uint8_t> bytes, int level);

/// Undoes it, also of several frames; gives at most `expected` + 1 bytes. What came before damage is kept only if
/// `stored` just ends early.
Decompressed decompress_zstd(std::span<const std::uint8_t> stored, std::size_t expected);

}  // namespace waymark::compression
