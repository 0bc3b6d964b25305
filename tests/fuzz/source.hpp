// SPDX-License-Identifier: Apache-2.0
// Harnesses of source plugins; the plugin is part of the program.
#pragma once

#include <string>

#include "waymark/interface/rig.hpp"

namespace waymark::fuzz {

/// Builds the source from `yaml`, whose relative paths count from `folder()`, and reads it to its end. What it delivers
/// must be as the interface demands: payloads of the channel's type with valid numbers, in order of arrival.
/// `valid_numbers`: false where the log may contain numbers that the host is to refuse.
void read_source(const std::string& yaml, const Rig& rig, bool valid_numbers = true);

}  // namespace waymark::fuzz
