// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "waymark/interface/snapshot.hpp"
#include "waymark/io/file_stems.hpp"
#include "waymark/io/output_file.hpp"

namespace waymark::map_formats {

/// Writes the maps of the best particle into a folder, in the formats of their own modules, dense maps without one as
/// grids of map_server, and last the manifest that names one file of each. Nothing if there is no map with content.
/// Throws Error.
void write_maps(const Snapshot& last, const std::filesystem::path& folder, FileStems stems, Belongs belongs);

}  // namespace waymark::map_formats
