// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "plugins/shared/compression/decompressed.hpp"

namespace waymark::compression {

/// One frame of LZ4 with a checksum of its content.
std::vector<std::uint8_t> compress_lz4(std::span<const std::uint8_t> bytes);

/// Undoes it; gives at most `expected` + 1 bytes.
Decompressed decompress_lz4(std::span<const std::uint8_t> stored, std::size_t expected);

}  // namespace waymark::compression
