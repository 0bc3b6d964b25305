// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "waymark/config/config.hpp"

namespace waymark::command {

/// True if the file is named like a flight record (.mcap), not like a YAML.
bool is_flight_record(const std::filesystem::path& file);

/// The configuration of the run that a flight record is of: what the sink `recorder` attached, with the record as its
/// source, and without what only a running robot has. It is not recorded again. Relative paths count from the folder of
/// the YAML that was run, where that still is, else from that of the record. Throws Error if the file is not a flight
/// record, ConfigError as `Config::load`.
Config config_of_flight_record(const std::filesystem::path& file, std::vector<Config::Override> overrides);

}  // namespace waymark::command
