// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "feature_map_settings.hpp"
#include "feature_observation.hpp"
#include "waymark/pose.hpp"

namespace waymark {

/// True if the sensor must have seen a cylinder at `p_map` with `radius` from this pose: inside the field of view, and
/// every beam over its width goes on beyond it. Where the detections did not come from a scan, the field of view of the
/// settings decides alone.
bool should_be_seen(const Eigen::Vector2d& p_map, double radius, const Pose& T_map_base, const ScanView& view,
                    const ExistenceSettings& settings);

}  // namespace waymark
