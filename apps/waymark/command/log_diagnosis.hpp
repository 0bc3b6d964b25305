// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "waymark/host/diagnosis.hpp"

namespace waymark::command {

/// As much of a log is looked at without a length that is given [s].
inline constexpr double kDiagnosedSeconds = 400.0;

/// Gives a diagnosis the first `until_s` seconds of a robot's log, without a filter; `length_s`: how much there was.
/// What follows is read only until every sensor has delivered. An error of the log ends it there, and is returned.
std::string diagnose_log(host::Robot& robot, host::Diagnosis& diagnosis, double until_s, double& length_s);

}  // namespace waymark::command
