// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "waymark/interface/source.hpp"

namespace waymark::log_sink {

/// A text as a quoted scalar of YAML that no variable is replaced in.
std::string in_quotes(std::string_view text);

/// Writes the reference's files into the folder. Returns what the csv source needs to read them, as lines of YAML with
/// `indent`; empty if there is nothing to write. Throws Error.
std::string write_reference(const Reference& reference, const std::filesystem::path& folder, std::string_view indent);

/// The run's configuration with another source, this log. Sinks that write logs are switched
/// off, and so are maps whose first input is not in the log.
/// `config`: the effective configuration; `source`: value of `source`, as YAML; `yaml_folder`: where the run's own YAML
/// lies; `silent`: indices of the sensors that are not in the log. Throws ConfigError if `config` is not a
/// configuration.
std::string replay_config(std::string_view config, std::string_view source, const std::filesystem::path& yaml_folder,
                          const std::vector<std::size_t>& silent);

}  // namespace waymark::log_sink
