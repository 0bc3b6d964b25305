// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

namespace waymark::command {

/// Adds to `waymark map` what makes a map of others: crop, merge, georeference.
void add_map_edits(CLI::App& map_command, int& exit_code);

}  // namespace waymark::command
