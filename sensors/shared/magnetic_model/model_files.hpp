// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

namespace waymark::magnetic_model {

/// Folders in which the shipped model may lie: that of the environment variable WAYMARK_MAGNETIC_MODEL, then those
/// beside the library or program that this code is part of.
std::vector<std::filesystem::path> model_folders();

}  // namespace waymark::magnetic_model
