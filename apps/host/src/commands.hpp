// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "gap_watch.hpp"
#include "waymark/host/fusion.hpp"
#include "waymark/host/robot.hpp"

namespace waymark::host {

/// What commands need beside the filter.
struct CommandOutputs {
  std::function<std::string()> save_maps;   ///< returns the folder
  std::function<std::string()> checkpoint;  ///< returns the file
  std::function<std::string()> status;      ///< one line of JSON
  std::function<void()> stop;
  std::function<void(const std::string&)> retune;  ///< key=value of a sensor or map; throws Error if it is refused
  std::function<void(std::uint32_t sensor, const Gap&)> note_missing;  ///< of a record
};

/// Records that so many measurements of a sensor were dropped before the filter: a command that only records give.
std::string dropped_command(const std::string& sensor, std::size_t count);

/// Records that measurements of a sensor did not arrive: a command that only records give.
std::string missing_command(const std::string& sensor, const Gap& gap);

/// True if the command changes the filter's results: it is recorded, and a replay repeats it.
bool steers(std::string_view command);

/// Executes one command; `is_record`: of a record that is replayed. Returns the reply, one line: "ok …" or "error: …".
/// Never throws.
std::string execute(std::string_view command, Fusion& fusion, const Robot& robot, const CommandOutputs& outputs,
                    bool is_record);

}  // namespace waymark::host
