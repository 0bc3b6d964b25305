// SPDX-License-Identifier: Apache-2.0
#include "payload_content.hpp"

#include <algorithm>
#include <cmath>

#include "waymark/interface/payloads.hpp"

namespace waymark::testing {

namespace {

template <class T>
const T* as(const Payload& payload) {
  return payload.type() == T::kType ? static_cast<const T*>(&payload) : nullptr;
}

template <class... T>
std::string bytes_of(const T&... values) {
  std::string out;
  (out.append(reinterpret_cast<const char*>(&values), sizeof values), ...);
  return out;
}

std::string bytes_of(const std::vector<float>& values) {
  return std::to_string(values.size()) + ":" +
         std::string(reinterpret_cast<const char*>(values.data()), sizeof(float) * values.size());
}

template <class... T>
bool finite(const T&... values) {
  return (std::isfinite(values) && ...);
}

std::string problem_of_scan(const LaserScan& scan) {
  if (!finite(scan.start_rad, scan.step_rad) || scan.step_rad == 0.0)
    return "a scan's start or step is not finite, or the step is zero";
  if (scan.ranges_m.empty()) return "a scan without beams";
  if (std::any_of(scan.ranges_m.begin(), scan.ranges_m.end(), [](float r) { return std::isnan(r) || r < 0.0f; })) {
    return "a scan's range is negative or NaN";
  }
  if (!scan.intensities.empty() && scan.intensities.size() != scan.ranges_m.size())
    return "a scan has not as many intensities as ranges";
  return {};
}

std::string bytes_of(const std::vector<Eigen::Vector3f>& points) {
  std::string out = std::to_string(points.size()) + ":";
  for (const Eigen::Vector3f& p : points) out += bytes_of(p.x(), p.y(), p.z());
  return out;
}

std::string problem_of_cloud(const PointCloud& cloud) {
  if (std::any_of(cloud.points_m.begin(), cloud.points_m.end(), [](const auto& p) { return !p.allFinite(); }))
    return "a point of a cloud is not finite";
  for (const auto* of_each : {&cloud.offsets_s, &cloud.intensities}) {
    if (!of_each->empty() && of_each->size() != cloud.points_m.size())
      return "a cloud has not as many offsets or intensities as points";
  }
  if (std::any_of(cloud.offsets_s.begin(), cloud.offsets_s.end(), [](float t) { return !std::isfinite(t); }))
    return "an offset of a cloud is not finite";
  return {};
}

std::string problem_of_fix(const GnssFix& fix) {
  const bool local = finite(fix.p_map_antenna.x(), fix.p_map_antenna.y());
  const bool geodetic = finite(fix.latitude_deg, fix.longitude_deg);
  if (fix.type != GnssFix::Type::none && !local && !geodetic)
    return "a fix has neither east and north nor latitude and longitude";
  return {};
}

std::string problem_of_imu(const ImuSample& sample) {
  for (const auto& v : {sample.w_sensor, sample.f_sensor, sample.m_sensor}) {
    if (!v.allFinite() && !v.array().isNaN().all()) return "a vector of an IMU is neither finite nor unknown";
  }
  const auto& q = sample.q_enu_sensor.coeffs();
  if (!q.array().isNaN().all() && !(std::abs(q.norm() - 1.0) < 1e-6))
    return "an orientation is neither a unit quaternion nor unknown";
  return {};
}

std::string problem_of_landmarks(const LandmarkObservations& seen) {
  for (const auto& one : seen.landmarks) {
    if (!finite(one.range_m, one.bearing_rad) || one.range_m < 0.0)
      return "a landmark's range or bearing is not finite, or the range is negative";
    if (std::isinf(one.radius_m)) return "a landmark's radius is infinite";
  }
  return {};
}

}  // namespace

std::string content_of(const Payload& payload) {
  if (const auto* p = as<WheelSpeeds>(payload)) return bytes_of(p->left_mps, p->right_mps);
  if (const auto* p = as<WheelSteering>(payload)) return bytes_of(p->speed_mps, p->steering_rad);
  if (const auto* p = as<BodyTwist>(payload)) return bytes_of(p->v_x_mps, p->v_y_mps, p->w_z_radps);
  if (const auto* p = as<PoseIncrement>(payload)) return bytes_of(p->interval_s, p->x_m, p->y_m, p->yaw_rad);
  if (const auto* p = as<GnssFix>(payload)) {
    return bytes_of(p->p_map_antenna.x(), p->p_map_antenna.y(), p->p_map_antenna.z(), p->latitude_deg, p->longitude_deg,
                    p->height_m, p->sigma_horizontal_m, p->sigma_vertical_m, p->hdop, p->satellites, p->type,
                    p->speed_mps, p->course_rad);
  }
  if (const auto* p = as<ImuSample>(payload)) {
    std::string out;
    for (const auto& v : {p->w_sensor, p->f_sensor, p->m_sensor}) out += bytes_of(v.x(), v.y(), v.z());
    return out + bytes_of(p->q_enu_sensor.w(), p->q_enu_sensor.x(), p->q_enu_sensor.y(), p->q_enu_sensor.z());
  }
  if (const auto* p = as<MagneticField>(payload)) return bytes_of(p->m_sensor.x(), p->m_sensor.y(), p->m_sensor.z());
  if (const auto* p = as<CompassHeading>(payload)) return bytes_of(p->heading_rad, p->sigma_rad, p->from_true_north);
  if (const auto* p = as<Height>(payload)) return bytes_of(p->height_m, p->sigma_m);
  if (const auto* p = as<LaserScan>(payload))
    return bytes_of(p->start_rad, p->step_rad) + bytes_of(p->ranges_m) + bytes_of(p->intensities);
  if (const auto* p = as<PointCloud>(payload))
    return bytes_of(p->points_m) + bytes_of(p->offsets_s) + bytes_of(p->intensities);
  if (const auto* p = as<LandmarkObservations>(payload)) {
    std::string out;
    for (const auto& one : p->landmarks) out += bytes_of(one.range_m, one.bearing_rad, one.radius_m, one.identity);
    return out;
  }
  return {};
}

std::string problem_of(const Payload& payload) {
  const std::string not_finite = "a value is not finite";
  if (const auto* p = as<WheelSpeeds>(payload)) return finite(p->left_mps, p->right_mps) ? "" : not_finite;
  if (const auto* p = as<WheelSteering>(payload)) return finite(p->speed_mps, p->steering_rad) ? "" : not_finite;
  if (const auto* p = as<BodyTwist>(payload)) return finite(p->v_x_mps, p->v_y_mps, p->w_z_radps) ? "" : not_finite;
  if (const auto* p = as<PoseIncrement>(payload)) {
    if (!finite(p->interval_s, p->x_m, p->y_m, p->yaw_rad)) return not_finite;
    return p->interval_s > 0.0 ? "" : "its interval is not positive";
  }
  if (const auto* p = as<GnssFix>(payload)) return problem_of_fix(*p);
  if (const auto* p = as<ImuSample>(payload)) return problem_of_imu(*p);
  if (const auto* p = as<MagneticField>(payload)) return p->m_sensor.allFinite() ? "" : not_finite;
  if (const auto* p = as<CompassHeading>(payload)) return finite(p->heading_rad) ? "" : not_finite;
  if (const auto* p = as<Height>(payload)) return finite(p->height_m) ? "" : not_finite;
  if (const auto* p = as<LaserScan>(payload)) return problem_of_scan(*p);
  if (const auto* p = as<PointCloud>(payload)) return problem_of_cloud(*p);
  if (const auto* p = as<LandmarkObservations>(payload)) return problem_of_landmarks(*p);
  return {};
}

}  // namespace waymark::testing
