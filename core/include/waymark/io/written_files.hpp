// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

#include "waymark/base/api.hpp"

namespace waymark {

/// The files that the last run wrote into its output folder, among its results: a line `bytes name` each.
inline constexpr std::string_view kWrittenFilesList = ".waymark_files";
/// The same of a run that has not ended: a name on each line.
inline constexpr std::string_view kOpenWrittenFilesList = ".waymark_files.new";

/// Adds a file that was completed to the open list of the nearest folder above it that has one; without one it belongs
/// to no run. `OutputFile` and `write_file` call it. A list that cannot be written to stays as it is: the file is then
/// not replaced by a later run.
WAYMARK_API void note_written(const std::filesystem::path& file);

}  // namespace waymark
