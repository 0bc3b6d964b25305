// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "waymark/host/fusion.hpp"
#include "waymark/host/robot.hpp"

namespace waymark::host {

/// State of a running robot as one line of JSON: pose, health, and for each sensor mode, counts and latency. The pose
/// is lost while nothing arrives: `silence`, zero otherwise.
std::string status_line(const Fusion& fusion, const Robot& robot, const LiveReport& live, Duration silence);

}  // namespace waymark::host
