// SPDX-License-Identifier: Apache-2.0
// Harnesses of source plugins; the plugins are parts of the program.
#pragma once

#include <string>

#include "waymark/base/time.hpp"
#include "waymark/interface/rig.hpp"
#include "waymark/plugin/descriptor.hpp"

namespace waymark::fuzz {

/// What must hold for the measurements of a source.
struct Demands {
  bool valid_numbers = true;  ///< false where the log may contain numbers that the host is to refuse
  bool are_past = true;       ///< no stamp lies after its arrival by more than `max_ahead`
  bool in_sequence = true;    ///< sequence numbers rise
  Duration max_ahead{};       ///< what the source admits
};

/// Of recordings of ROS: their default of `max_ahead_s`.
constexpr Duration kMaxAheadOfRecording = std::chrono::milliseconds(100);

/// Builds the source of `plugin` from `yaml`, whose relative paths count from `folder()`, and reads it to its end. What
/// it delivers must be as the interface demands: payloads of the channel's type with valid numbers, in order of
/// arrival.
void read_source(const PluginDescriptor& plugin, const std::string& yaml, const Rig& rig, const Demands& demands = {});

}  // namespace waymark::fuzz
