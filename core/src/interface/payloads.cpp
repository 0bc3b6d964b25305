// SPDX-License-Identifier: Apache-2.0
#include "waymark/interface/payloads.hpp"

#include <algorithm>
#include <cmath>

namespace waymark {
namespace {

constexpr double kUnitNorm = 1e-6;

bool none_or_one_each(const std::vector<float>& of_each, std::size_t count) {
  return of_each.empty() || of_each.size() == count;
}

}  // namespace

std::string_view PoseIncrement::contradiction() const { return interval_s > 0.0 ? "" : "its interval is not positive"; }

std::string_view GnssFix::contradiction() const {
  const bool local = std::isfinite(p_map_antenna.x()) && std::isfinite(p_map_antenna.y());
  const bool geodetic = std::isfinite(latitude_deg) && std::isfinite(longitude_deg);
  if (type == Type::none || local || geodetic) return {};
  return "a fix has neither east and north nor latitude and longitude";
}

Eigen::Vector3d LaserScan::p_sensor_end(std::ptrdiff_t k) const {
  const double bearing = start_rad + static_cast<double>(k) * step_rad;
  const double range_m = ranges_m[static_cast<std::size_t>(k)];
  return {range_m * std::cos(bearing), range_m * std::sin(bearing), 0.0};
}

std::string_view LaserScan::contradiction() const {
  if (step_rad == 0.0) return "a scan's step is zero";
  if (ranges_m.empty()) return "a scan without beams";
  if (std::ranges::any_of(ranges_m, [](float r) { return std::isnan(r) || r < 0.0f; })) {
    return "a scan's range is negative or NaN";
  }
  return none_or_one_each(intensities, ranges_m.size()) ? "" : "a scan has not as many intensities as ranges";
}

std::string_view PointCloud::contradiction() const {
  const bool fits = none_or_one_each(offsets_s, points_m.size()) && none_or_one_each(intensities, points_m.size());
  return fits ? "" : "a cloud has not as many offsets or intensities as points";
}

std::string_view ImuSample::contradiction() const {
  for (const auto* v : {&w_sensor, &f_sensor, &m_sensor}) {
    if (!v->allFinite() && !v->array().isNaN().all()) return "a vector of an IMU is neither finite nor unknown";
  }
  const auto& q = q_enu_sensor.coeffs();
  const bool plausible = q.array().isNaN().all() || std::abs(q.norm() - 1.0) < kUnitNorm;
  return plausible ? "" : "an orientation is neither a unit quaternion nor unknown";
}

std::string_view LandmarkObservations::contradiction() const {
  const bool behind = std::ranges::any_of(landmarks, [](const One& one) { return one.range_m < 0.0; });
  return behind ? "a landmark's range is negative" : "";
}

std::string_view Ranges::contradiction() const {
  for (const One& one : ranges) {
    if (one.beacon < 0) return "a beacon's number is negative";
    if (one.reference < 0 && one.range_m < 0.0) return "a range is negative";
    if (one.reference == one.beacon) return "a beacon is its own reference";
  }
  return {};
}

std::string_view RadarTargets::contradiction() const {
  const bool behind = std::ranges::any_of(targets, [](const One& one) { return one.range_m < 0.0; });
  return behind ? "a target's range is negative" : "";
}

}  // namespace waymark
