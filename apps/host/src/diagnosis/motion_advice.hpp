// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "motion_scales.hpp"

namespace waymark::host::diagnosis {

/// What was seen of an observer whose turns are `ratio` times those of a group.
std::string seen_of_yaw(const Case& c, const Agreement& agreement, std::size_t i, int group, const Ratio& ratio);

/// The same of its way.
std::string seen_of_way(const Case& c, const Agreement& agreement, std::size_t i, int group, const Ratio& ratio);

/// The line to change so that a sensor's turns become `ratio` times smaller.
std::string change_of_yaw(const Case& c, const Observer& observer, const Ratio& ratio, const Scales& scales);

/// The same for its way.
std::string change_of_way(const Case& c, const Observer& observer, const Ratio& ratio, const Scales& scales);

}  // namespace waymark::host::diagnosis
