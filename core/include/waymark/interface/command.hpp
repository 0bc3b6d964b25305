// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "waymark/interface/measurement.hpp"

namespace waymark {

/// A command to the running filter, in the order of the measurements: `waymark ctl` on a live robot, and a record of it
/// on replay. Its channel has no sensor (`Channel::sensor` is empty).
struct Command : PayloadOf<Command> {
  static constexpr std::string_view kType = "waymark/Command@1";
  std::string text;
};

}  // namespace waymark
