// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "motion_scales.hpp"

namespace waymark::host::diagnosis {

/// How unusual a mistake must be that makes a sensor's turns `ratio` times as far: 1 for one that everybody makes, 3
/// for an unusual one, near 0 for one that something else points to.
double cost_of_yaw(const Case& c, const MotionAgreement& motion, std::size_t i, const Ratio& ratio,
                   const Scales& scales);

/// The same for its ways.
double cost_of_way(const Case& c, const MotionAgreement& motion, const Observer& observer, const Ratio& ratio,
                   const Scales& scales);

}  // namespace waymark::host::diagnosis
