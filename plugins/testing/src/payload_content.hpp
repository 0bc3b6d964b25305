// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "waymark/interface/measurement.hpp"

namespace waymark::testing {

/// All registered values of a payload, exactly; empty if it registers no fields.
std::string content_of(const Payload& payload);

}  // namespace waymark::testing
