// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "waymark/base/time.hpp"

namespace waymark::kitti {

/// Reads "2011-09-26 13:02:25.951199337", taken as UTC, to the nanosecond. Throws DataError without a place.
Time parse_timestamp(std::string_view text);

/// The stamps of a file, line by line. Throws DataError (`file:line: …`) if the file cannot be read or a line is no
/// stamp.
std::vector<Time> read_timestamps(const std::filesystem::path& file);

}  // namespace waymark::kitti
