// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/extraction/cylinder_extraction.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "map_modules/feature_map/extraction/camera_extraction.hpp"
#include "waymark/base/error.hpp"

namespace waymark::feature_map {

namespace {

constexpr float kFree = std::numeric_limits<float>::infinity();
constexpr float kBlind = 0.0f;

/// Whether the scan recedes by `background` within two beams beyond `edge` in direction `step`.
enum class Surroundings { far, near, hidden };

Surroundings look_beyond(const std::vector<float>& ranges, int edge, int step, double background) {
  constexpr int kReach = 2;
  for (int k = 1; k <= kReach; ++k) {
    const int i = edge + k * step;
    if (i < 0 || i >= static_cast<int>(ranges.size())) return Surroundings::hidden;
    const float r = ranges[static_cast<std::size_t>(i)];
    if (r == kBlind) return Surroundings::hidden;
    if (r > ranges[static_cast<std::size_t>(edge)] + background) return Surroundings::far;
  }
  return Surroundings::near;
}

/// True if a return that is not the candidate's own lies within `distance` of its centre.
bool has_neighbour(const ScanView& view, const Candidate& candidate, double distance) {
  const double center = candidate.surface_range + candidate.radius;
  const double bearing = candidate.bearing;
  // Only beams within this angle can come that near.
  const double reach = distance < center ? std::asin(distance / center) : std::numbers::pi;
  const int beams = static_cast<int>(view.ranges.size());
  const int around = static_cast<int>(std::ceil(std::min(reach / std::abs(view.step), 1.0 * beams)));
  const int middle = (candidate.first_beam + candidate.last_beam) / 2;
  const int from = std::max(0, middle - around);
  const int to = std::min(beams - 1, middle + around + 1);
  for (int i = from; i <= to; ++i) {
    if (i >= candidate.first_beam && i <= candidate.last_beam) continue;
    const float r = view.ranges[static_cast<std::size_t>(i)];
    if (r == kBlind || r == kFree) continue;
    const double angle = view.start + i * view.step - bearing;
    if (r * r + center * center - 2.0 * r * center * std::cos(angle) < distance * distance) return true;
  }
  return false;
}

Verdict judge(const ScanView& view, const Candidate& candidate, double width, const ExtractionSettings& s) {
  if (candidate.mean_range > s.range_max) return Verdict::too_far;
  const int count = candidate.last_beam - candidate.first_beam + 1;
  if (count * std::abs(view.step) >= std::numbers::pi / 2.0 || width > s.width_max) return Verdict::too_wide;
  if (count < s.min_beams) return Verdict::too_few_beams;
  const Surroundings before = look_beyond(view.ranges, candidate.first_beam, -1, s.background);
  const Surroundings after = look_beyond(view.ranges, candidate.last_beam, +1, s.background);
  if (before == Surroundings::hidden || after == Surroundings::hidden) return Verdict::hidden;
  if (before == Surroundings::near || after == Surroundings::near) return Verdict::no_background;
  if (s.isolation > 0.0 && has_neighbour(view, candidate, s.isolation)) return Verdict::crowded;
  return Verdict::accepted;
}

Signature reflectivity(const LaserScan& scan, int first, int last, const ExtractionSettings& s, double floor) {
  if (scan.intensities.empty()) return {0.5f, 0.5f};
  const auto begin = scan.intensities.begin();
  const bool bright = std::any_of(begin + first, begin + last + 1, [&](float i) { return i > s.bright_above; });
  const auto f = static_cast<float>(floor);
  return bright ? Signature{f, 1.0f - f} : Signature{1.0f - f, f};
}

/// Of the candidate's middle, with what the sensor moved across the beam since the stamp.
double bearing_at_stamp(const ScanView& view, const Candidate& candidate) {
  const double beam = 0.5 * (candidate.first_beam + candidate.last_beam);
  const Eigen::Vector2d across(-std::sin(candidate.bearing), std::cos(candidate.bearing));
  return candidate.bearing + beam * view.way_per_beam.dot(across) / (candidate.surface_range + candidate.radius);
}

}  // namespace

Detection make_detection(double surface_range, double bearing, double radius, const Pose& T_base_sensor,
                         const DetectionNoise& noise) {
  const double distance = surface_range + radius;
  const double range_sigma = std::hypot(noise.range, noise.range_share * surface_range);
  const double c = std::cos(bearing);
  const double s = std::sin(bearing);
  // (x, y, r) of (d, bearing, r), plus a tangential part that does not shrink with range.
  Eigen::Matrix3d J;
  J << c, -distance * s, c, s, distance * c, s, 0.0, 0.0, 1.0;
  Eigen::Matrix3d R =
      J *
      Eigen::Vector3d(range_sigma * range_sigma, noise.bearing * noise.bearing, noise.radius * noise.radius)
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

ScanView view_of(const LaserScan& scan, const Pose& T_base_sensor, const ExtractionSettings& s,
                 const MotionWindow& motion) {
  if (scan.ranges_m.empty()) throw DataError("a scan without beams");
  ScanView view{.p_base_sensor = T_base_sensor.p.head<2>(),
                .yaw_base_sensor = T_base_sensor.yaw(),
                .start = scan.start_rad,
                .step = scan.step_rad,
                .ranges = {}};
  if (scan.beam_interval_s != 0.0) {
    const Eigen::Matrix3d R_sensor_base = T_base_sensor.q.toRotationMatrix().transpose();
    const Eigen::Vector3d v = R_sensor_base * (motion.v_base + motion.w_base.cross(T_base_sensor.p));
    view.way_per_beam = scan.beam_interval_s * v.head<2>();
    const double turn = scan.beam_interval_s * (R_sensor_base * motion.w_base).z();
    if (!(std::abs(turn) < 0.5 * std::abs(scan.step_rad))) throw DataError("the robot turns as fast as its scanner");
    view.step += turn;
  }
  const bool moves = !view.way_per_beam.isZero(0.0);
  const auto at_stamp = [&](float range, std::size_t i) {
    if (!moves || range == kBlind) return range;
    const auto beam = static_cast<double>(i);
    const double bearing = view.start + beam * view.step;
    const double along = beam * view.way_per_beam.dot(Eigen::Vector2d(std::cos(bearing), std::sin(bearing)));
    return std::max(range + static_cast<float>(along), std::numeric_limits<float>::min());
  };
  view.ranges.resize(scan.ranges_m.size());
  for (std::size_t i = 0; i < view.ranges.size(); ++i) {
    const float r = scan.ranges_m[i];
    view.ranges[i] = r >= static_cast<float>(s.no_return)
                         ? kFree
                         : (r >= static_cast<float>(s.range_min) ? at_stamp(r, i) : kBlind);  // NaN is blind, too
  }
  return view;
}

std::vector<Candidate> examine(const ScanView& view, const ExtractionSettings& s) {
  std::vector<Candidate> candidates;
  const int beams = static_cast<int>(view.ranges.size());
  const auto range_of = [&](int beam) { return view.ranges[static_cast<std::size_t>(beam)]; };
  for (int first = 0; first < beams;) {
    const float start_range = range_of(first);
    int last = first;
    if (start_range == kBlind || start_range == kFree) {
      ++first;
      continue;
    }
    double sum = start_range;
    float nearest = start_range;
    float farthest = start_range;
    while (last + 1 < beams) {
      const float next = range_of(last + 1);
      if (next == kBlind || next == kFree || std::abs(next - range_of(last)) > s.segment_jump) break;
      sum += next;
      nearest = std::min(nearest, next);
      farthest = std::max(farthest, next);
      ++last;
    }
    const int count = last - first + 1;
    const double half_width = std::sin(std::min(0.5 * count * std::abs(view.step), 0.25 * std::numbers::pi));
    Candidate candidate;
    candidate.first_beam = first;
    candidate.last_beam = last;
    candidate.mean_range = sum / count;
    candidate.bearing = view.start + 0.5 * (first + last) * view.step;
    candidate.radius = candidate.mean_range * half_width / (1.0 - half_width);
    candidate.surface_range = front_range(candidate, candidate.radius);
    // A wall seen along its length looks narrow, but it is deep.
    const double extent = std::max(2.0 * candidate.mean_range * half_width, static_cast<double>(farthest - nearest));
    candidate.verdict = judge(view, candidate, extent, s);
    candidates.push_back(candidate);
    first = last + 1;
  }
  return candidates;
}

double front_range(const Candidate& candidate, double radius) {
  constexpr double kFront = 1.0 - std::numbers::pi / 4.0;
  const int count = candidate.last_beam - candidate.first_beam + 1;
  return candidate.mean_range - (count > 2 ? kFront * radius : 0.0);
}

FeatureObservation observe(const LaserScan& scan, ScanView view, const std::vector<Candidate>& candidates,
                           const ImageLook* look, const Pose& T_base_sensor, const FeatureMapSettings& settings) {
  FeatureObservation observation;
  observation.view = std::move(view);
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const Candidate& candidate = candidates[i];
    if (candidate.verdict != Verdict::accepted) continue;
    const CandidateLook* seen = look != nullptr ? look->of(i) : nullptr;
    DetectionNoise noise = settings.noise;
    if (seen != nullptr) noise.radius = seen->radius_sigma;
    // Without the radius as an attribute its noise is none of the landmark's, but the centre still lies a radius behind
    // the surface.
    if (!settings.use_radius) noise.radius = 0.0;
    Detection detection = make_detection(candidate.surface_range, bearing_at_stamp(observation.view, candidate),
                                         candidate.radius, T_base_sensor, noise);
    detection.first_beam = candidate.first_beam;
    detection.last_beam = candidate.last_beam;
    if (look == nullptr) {
      detection.signature = reflectivity(scan, candidate.first_beam, candidate.last_beam, settings.extraction,
                                         settings.association.signature_floor);
    } else if (seen != nullptr) {
      detection.signature = seen->signature;
    } else {
      detection.may_be_new = settings.camera->unseen == Unseen::keep;
    }
    observation.max_range = std::max(observation.max_range, detection.xyr.head<2>().norm());
    observation.detections.push_back(detection);
  }
  return observation;
}

FeatureObservation extract_cylinders(const LaserScan& scan, const Pose& T_base_sensor,
                                     const FeatureMapSettings& settings) {
  ScanView view = view_of(scan, T_base_sensor, settings.extraction);
  const std::vector<Candidate> candidates = examine(view, settings.extraction);
  return observe(scan, std::move(view), candidates, nullptr, T_base_sensor, settings);
}

}  // namespace waymark::feature_map
