// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

namespace waymark::rosbag2 {

/// The parts of a bag, in the order of recording.
struct BagParts {
  std::vector<std::filesystem::path> files;
  bool compressed_messages = false;  ///< each message on its own, with zstd
};

/// Reads `metadata.yaml` of a folder; without one, as a crash leaves it, all parts in the folder count, in the order of
/// their names. A file is a part by itself. Throws DataError.
BagParts find_parts(const std::filesystem::path& bag);

}  // namespace waymark::rosbag2
