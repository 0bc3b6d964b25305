// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string_view>

namespace waymark::maps {

/// The text at the beginning of a file of liboctomap, and what its nodes come to.
struct OctreeBytes {
  bool is_binary = false;      ///< .bt: a leaf is occupied or free; else .ot: every node has its log-odds
  double resolution_m = 0.0;   ///< side of the smallest voxel
  std::size_t data_begin = 0;  ///< byte at which the nodes begin
  std::uint64_t nodes = 0;     ///< inner ones and leaves
};

/// Looks through the bytes of a `.bt` or `.ot` before liboctomap reads them: it neither notices the end of a truncated
/// file nor bounds the depth of what it reads. `file` is for messages. Throws DataError with the file, what is wrong,
/// at which byte, and what was expected.
OctreeBytes inspect_octree(std::string_view content, const std::filesystem::path& file);

}  // namespace waymark::maps
