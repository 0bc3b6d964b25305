// SPDX-License-Identifier: Apache-2.0
#include "cylinder_extraction.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "waymark/error.hpp"

namespace waymark {

namespace {

constexpr float kFree = std::numeric_limits<float>::infinity();
constexpr float kBlind = 0.0f;

std::vector<float> clean_ranges(const LaserScan& scan, const ExtractionSettings& s) {
  std::vector<float> ranges(scan.ranges_m.size());
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const float r = scan.ranges_m[i];
    ranges[i] = r >= static_cast<float>(s.no_return)
                    ? kFree
                    : (r >= static_cast<float>(s.range_min) ? r : kBlind);  // NaN is blind, too
  }
  return ranges;
}

/// True if the scan recedes by `background` within two beams beyond `edge` in direction `step`. The border of the scan
/// and blind beams hide the surroundings: no.
bool recedes(const std::vector<float>& ranges, int edge, int step, double background) {
  constexpr int kReach = 2;
  for (int k = 1; k <= kReach; ++k) {
    const int i = edge + k * step;
    if (i < 0 || i >= static_cast<int>(ranges.size())) return false;
    const float r = ranges[static_cast<std::size_t>(i)];
    if (r == kBlind) return false;
    if (r > ranges[static_cast<std::size_t>(edge)] + background) return true;
  }
  return false;
}

Signature reflectivity(const LaserScan& scan, int first, int last, const ExtractionSettings& s, double floor) {
  if (scan.intensities.empty()) return {0.5f, 0.5f};
  const auto begin = scan.intensities.begin();
  const bool bright = std::any_of(begin + first, begin + last + 1, [&](float i) { return i > s.bright_above; });
  const auto f = static_cast<float>(floor);
  return bright ? Signature{f, 1.0f - f} : Signature{1.0f - f, f};
}

}  // namespace

Detection make_detection(double surface_range, double bearing, double radius, const Pose& T_base_sensor,
                         const DetectionNoise& noise) {
  const double distance = surface_range + radius;
  const double c = std::cos(bearing);
  const double s = std::sin(bearing);
  // (x, y, r) of (d, bearing, r), plus a tangential part that does not shrink with range.
  Eigen::Matrix3d J;
  J << c, -distance * s, c, s, distance * c, s, 0.0, 0.0, 1.0;
  Eigen::Matrix3d R =
      J *
      Eigen::Vector3d(noise.range * noise.range, noise.bearing * noise.bearing, noise.radius * noise.radius)
          .asDiagonal() *
      J.transpose();
  const Eigen::Vector3d tangent(-s, c, 0.0);
  R += noise.tangential * noise.tangential * tangent * tangent.transpose();

  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(T_base_sensor.yaw()).toRotationMatrix();
  Detection detection;
  detection.xyr << (T_base_sensor * Eigen::Vector3d(distance * c, distance * s, 0.0)).head<2>(), radius;
  detection.R = turn * R * turn.transpose();
  return detection;
}

FeatureObservation extract_cylinders(const LaserScan& scan, const Pose& T_base_sensor,
                                     const FeatureMapSettings& settings) {
  if (scan.ranges_m.empty()) throw DataError("a scan without beams");
  const ExtractionSettings& s = settings.extraction;
  FeatureObservation observation;
  observation.view = {T_base_sensor.p.head<2>(), T_base_sensor.yaw(), scan.start_rad, scan.step_rad,
                      clean_ranges(scan, s)};
  const std::vector<float>& ranges = observation.view.ranges;
  // Without the radius as an attribute its noise is none of the landmark's, but the centre still lies a radius behind
  // the surface.
  DetectionNoise noise = settings.noise;
  if (!settings.use_radius) noise.radius = 0.0;

  const int beams = static_cast<int>(ranges.size());
  const auto range_of = [&](int beam) { return ranges[static_cast<std::size_t>(beam)]; };
  for (int first = 0; first < beams;) {
    const float start_range = range_of(first);
    int last = first;
    if (start_range == kBlind || start_range == kFree) {
      ++first;
      continue;
    }
    double sum = start_range;
    while (last + 1 < beams) {
      const float next = range_of(last + 1);
      if (next == kBlind || next == kFree || std::abs(next - range_of(last)) > s.segment_jump) break;
      sum += next;
      ++last;
    }
    const int count = last - first + 1;
    const double mean = sum / count;
    const double half_width = std::sin(0.5 * count * std::abs(scan.step_rad));
    const bool candidate = mean <= s.range_max && count >= s.min_beams &&
                           count * std::abs(scan.step_rad) < std::numbers::pi / 2.0 &&
                           2.0 * mean * half_width <= s.width_max && recedes(ranges, first, -1, s.background) &&
                           recedes(ranges, last, +1, s.background);
    if (candidate) {
      // Beams hit a round front: on the average a little behind its nearest point.
      constexpr double kFront = 1.0 - std::numbers::pi / 4.0;
      const double radius = mean * half_width / (1.0 - half_width);
      const double bearing = scan.start_rad + 0.5 * (first + last) * scan.step_rad;
      Detection detection =
          make_detection(mean - (count > 2 ? kFront * radius : 0.0), bearing, radius, T_base_sensor, noise);
      detection.first_beam = first;
      detection.last_beam = last;
      detection.signature = reflectivity(scan, first, last, s, settings.association.signature_floor);
      observation.max_range = std::max(observation.max_range, detection.xyr.head<2>().norm());
      observation.detections.push_back(detection);
    }
    first = last + 1;
  }
  return observation;
}

}  // namespace waymark
