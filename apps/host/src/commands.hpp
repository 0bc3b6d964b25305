// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "waymark/host/fusion.hpp"
#include "waymark/host/robot.hpp"

namespace waymark::host {

/// What commands need beside the filter.
struct CommandOutputs {
  std::function<std::string()> save_maps;   ///< returns the folder
  std::function<std::string()> checkpoint;  ///< returns the file
  std::function<std::string()> status;      ///< one line of JSON
  std::function<void()> stop;
};

/// True if the command changes the filter's results: it is recorded, and a replay repeats it.
bool steers(std::string_view command);

/// Executes one command. Returns the reply, one line: "ok …" or "error: …". Never throws.
std::string execute(std::string_view command, Fusion& fusion, const Robot& robot, const CommandOutputs& outputs);

}  // namespace waymark::host
