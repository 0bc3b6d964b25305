// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "feature_map_settings.hpp"
#include "feature_observation.hpp"
#include "waymark/payloads.hpp"

namespace waymark {

/// Finds upright cylinders in a planar scan (estimation.md §4, extraction (a) and (c)): segments that stand out in
/// front of their surroundings on both sides. Bearing is the segment's middle; the radius comes from its angular width,
/// r = d s/(1 − s), s = sin(width/2). Throws DataError if the scan has no beams.
FeatureObservation extract_cylinders(const LaserScan& scan, const Pose& T_base_sensor,
                                     const FeatureMapSettings& settings);

/// A detection at range d to the surface, bearing and radius in the sensor's frame (4.1), taken to the base frame with
/// its noise.
Detection make_detection(double surface_range, double bearing, double radius, const Pose& T_base_sensor,
                         const DetectionNoise& noise);

}  // namespace waymark
