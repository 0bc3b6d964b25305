// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "waymark/interface/measurement.hpp"

namespace waymark::testing {

/// All numbers of a payload that core knows, exactly; empty for others.
std::string content_of(const Payload& payload);

/// What is wrong with the values of a payload that core knows; empty: nothing.
std::string problem_of(const Payload& payload);

}  // namespace waymark::testing
