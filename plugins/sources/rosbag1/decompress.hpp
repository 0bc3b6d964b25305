// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "plugins/shared/cdr/wire_reader.hpp"
#include "plugins/shared/compression/decompressed.hpp"

namespace waymark::rosbag1 {

using compression::Decompressed;

/// Most bytes that `stored` ones can be expected to unpack to: lz4 reaches 255 : 1; bz2 more, where all bytes are
/// equal, as in images of a covered camera.
std::uint64_t most_unpacked(std::uint64_t stored);

/// True for "none", "bz2" and "lz4".
bool knows_compression(std::string_view name);

/// Undoes the compression; `size` bytes are expected.
Decompressed decompress(std::string_view compression, ros::Bytes stored, std::size_t size);

}  // namespace waymark::rosbag1
