// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "waymark/host/session.hpp"

namespace waymark::host {

/// What went wrong in a run, a line each: the log, failed parts of the filter, sinks.
std::vector<std::string> failures_of(const SessionResult& result, const std::vector<std::string>& of_sinks);

/// How the maps of the best particle matched their scans; nothing for maps that match none.
std::vector<MatchReport> matches_of(const Snapshot& last);

/// Why a run counts as lost: its pose was lost for too large a share of its time; else empty.
std::string lost_of(const HealthTimes& times, double allowed);

}  // namespace waymark::host
