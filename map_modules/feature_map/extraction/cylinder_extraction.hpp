// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <string_view>
#include <vector>

#include "map_modules/feature_map/feature_map_settings.hpp"
#include "map_modules/feature_map/feature_observation.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::feature_map {

/// What became of a segment of a scan, by the first criterion that it fails.
enum class Verdict {
  accepted,
  too_far,        ///< mean range above `range_max_m`
  too_wide,       ///< wider or deeper than `width_max_m`, or wider than a quarter of a turn
  too_few_beams,  ///< fewer than `min_beams`
  hidden,         ///< at the border of the scan or next to a blind beam: its surroundings are not known
  no_background,  ///< the scan does not recede by `background_m` on both sides
  crowded,        ///< another return lies within `isolation_m` of its centre: a bush, grass, rising ground
  no_edges,       ///< the image shows no pair of vertical edges where its borders should be
  off_image       ///< the image does not show it, and `camera.unseen` is drop
};
inline constexpr std::size_t kVerdicts = 9;

/// The word for it in files: "too_far".
constexpr std::string_view name_of(Verdict verdict) {
  constexpr std::array<std::string_view, kVerdicts> kNames = {"accepted",      "too_far",  "too_wide",
                                                              "too_few_beams", "hidden",   "no_background",
                                                              "crowded",       "no_edges", "off_image"};
  return kNames[static_cast<std::size_t>(verdict)];
}

/// A segment: neighbouring beams that differ by at most `segment_jump_m`, taken as the front of a cylinder.
struct Candidate {
  int first_beam = 0;
  int last_beam = 0;
  double mean_range = 0.0;     ///< [m]
  double surface_range = 0.0;  ///< to the nearest point of the round front [m]
  double bearing = 0.0;        ///< of its middle, in the sensor's frame [rad]
  double radius = 0.0;         ///< from its angular width: r = d s/(1 − s), s = sin(width/2) [m]
  Verdict verdict = Verdict::accepted;
};

/// The scan with its ranges cleaned: blind, free or measured; motion-compensated to the stamp, if its beams have times
/// of their own. Throws DataError if the scan has no beams, or if the robot turns about as fast as the scanner.
ScanView view_of(const LaserScan& scan, const Pose& T_base_sensor, const ExtractionSettings& settings,
                 const MotionWindow& motion = {});

/// All segments of a scan in the order of its beams, each with the verdict of the criteria.
std::vector<Candidate> examine(const ScanView& view, const ExtractionSettings& settings);

/// Range to the nearest point of a round front of this radius: beams hit it a little behind, on the average.
double front_range(const Candidate& candidate, double radius);

struct ImageLook;

/// The accepted candidates as detections. `look` is null without a camera; with one, what it measured replaces the
/// scanner's radius and reflectivity, and without a usable image the signature is unknown.
FeatureObservation observe(const LaserScan& scan, ScanView view, const std::vector<Candidate>& candidates,
                           const ImageLook* look, const Pose& T_base_sensor, const FeatureMapSettings& settings);

/// Finds upright cylinders in a planar scan (docs/math/feature_map.md, "Extraction"): the accepted candidates of
/// `examine`, which stand out in front of their surroundings on both sides. Throws DataError if the scan has no beams.
FeatureObservation extract_cylinders(const LaserScan& scan, const Pose& T_base_sensor,
                                     const FeatureMapSettings& settings);

/// A detection at range d to the surface, bearing and radius in the sensor's frame (4.1), taken to the base frame with
/// its noise.
Detection make_detection(double surface_range, double bearing, double radius, const Pose& T_base_sensor,
                         const DetectionNoise& noise);

}  // namespace waymark::feature_map
