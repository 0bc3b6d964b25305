// SPDX-License-Identifier: Apache-2.0
// Clouds of files of their own, as one file of clouds for the source `clouds`.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "waymark/base/time.hpp"

namespace waymark::imports {

struct CloudImport {
  std::filesystem::path out;                         ///< gzip if it ends in .gz
  std::vector<std::filesystem::path> files;          ///< one cloud each, in the order of time
  std::filesystem::path times;                       ///< a line for each file with its time in s; empty: there is none
  bool times_in_names = false;                       ///< a file's name is its time: 1305031102.175304.pcd, or whole ns
  std::optional<Time> start;                         ///< of the first file, if there are no times; default 0
  Duration period = std::chrono::milliseconds(100);  ///< from file to file, if there are no times
};

struct ImportedClouds {
  std::size_t clouds = 0;
  std::uint64_t points = 0;
  bool intensities = false;
  bool times = false;
  Time first, last;
  std::vector<std::string> notes;
};

/// Throws DataError, with file and line or byte, if a file cannot be read, a time is none or not later than the one
/// before, or one file has intensities or times and another has not.
ImportedClouds import_clouds(const CloudImport& settings);

}  // namespace waymark::imports
