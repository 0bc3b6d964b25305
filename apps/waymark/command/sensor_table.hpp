// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "waymark/interface/snapshot.hpp"

namespace waymark::command {

/// A table with a row for every sensor: rate, measurements, how many were used and rejected, NIS, what that means. As
/// in the report. One line each, without newlines; empty without sensors.
std::vector<std::string> sensor_table(const RunReport& report);

}  // namespace waymark::command
