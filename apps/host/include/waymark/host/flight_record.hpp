// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "waymark/config/config.hpp"

namespace waymark::host {

/// What a flight record holds of the run that wrote it.
struct RecordedRun {
  Config config;     ///< see `recorded_run`
  std::string name;  ///< of the run's YAML, without its ending
};

/// True if the file is named like a flight record (.mcap), not like a YAML.
bool is_flight_record(const std::filesystem::path& file);

/// The run that a flight record is of. Its configuration is what the sink `recorder` attached, with the record as its
/// source, and without what only a running robot has. It is not recorded again. Relative paths count from the folder of
/// the YAML that was run, where that still is, else from that of the record. Throws Error if the file is not a flight
/// record, ConfigError as `Config::load`.
RecordedRun recorded_run(const std::filesystem::path& file, std::vector<Config::Override> overrides);

}  // namespace waymark::host
