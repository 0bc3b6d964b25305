// SPDX-License-Identifier: Apache-2.0
#include "radar_settings.hpp"

#include <numbers>

namespace waymark::radar {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180.0;

ScanSettings read_scan(const Config& config) {
  ScanSettings scan;
  scan.dimensions = static_cast<int>(
      config.integer_in({"dimensions", "2: a planar radar; 3: it measures elevations, and v_z is estimated"}, 2, 3, 2));
  scan.doppler_sigma_mps = config.positive({"doppler_sigma_mps", "m/s", "white noise of a radial velocity"}, 0.05);
  scan.azimuth_sigma_rad =
      kRadPerDeg *
      config.non_negative({"azimuth_sigma_deg", "°", "white noise of an azimuth in front; it grows with 1/cos"}, 0.3);
  scan.elevation_sigma_rad =
      kRadPerDeg *
      config.non_negative({"elevation_sigma_deg", "°", "the same of an elevation; with `dimensions: 3`"}, 1.0);
  scan.correlation = config.number_in(
      {"correlation", "correlation ρ of the errors of a scan's targets: n of them count as n / (1 + (n − 1) ρ)"}, 0.0,
      1.0, 0.1);
  scan.scan_sigma_mps = config.positive(
      {"scan_sigma_mps", "m/s", "error of the velocity that all targets of a scan share, per axis"}, 0.01);
  scan.scan_sigma_rad =
      kRadPerDeg *
      config.non_negative({"scan_sigma_deg", "°", "error of the angles that all targets of a scan share"}, 0.03);
  scan.gate_sigma =
      config.positive({"gate_sigma", "a target whose residual exceeds so many of its σ moves by itself"}, 3.0);
  scan.draws = static_cast<int>(config.integer_in(
      {"draws", "candidates of RANSAC; the default finds 30 % of static targets with planar radars"}, 1, 100'000, 100));
  scan.min_range_m = config.non_negative({"min_range_m", "m", "nearer targets are not used"}, 0.0);
  scan.min_inliers = static_cast<std::size_t>(
      config.integer_in({"min_inliers", "fewer targets that agree give no update"}, 3, 1'000'000, 8));
  scan.min_share = config.number_in(
      {"min_share", "a smaller share of targets that agree gives no update, and the sensor is degraded"}, 0.0, 1.0,
      0.3);
  return scan;
}

RearAxle read_rear_axle(const Config& config) {
  RearAxle axle;
  axle.noise =
      config.positive({"noise_m_per_sqrt_s", "m/√s", "noise density of the axle's velocity sideways, at rest"}, 0.01);
  axle.noise_per_speed = config.non_negative({"noise_per_speed_sqrt_s", "√s", "the same, per speed"}, 0.001);
  axle.slip = config.number_in({"slip_rad_s2_per_m", "rad s²/m", "slip angle of its tyres per lateral acceleration"},
                               -0.1, 0.1, 0.0);
  axle.slip_sigma = config.non_negative(
      {"slip_sigma_rad_s2_per_m", "rad s²/m", "the slip as a state: its first σ; 0: no state"}, 0.0);
  config.reject_unread();
  return axle;
}

}  // namespace

RadarSettings RadarSettings::read(const Config& config) {
  RadarSettings settings;
  settings.scan = read_scan(config);
  settings.error_time_s = config.non_negative(
      {"error_time_s", "s",
       "how long errors stay that targets share: their covariance counts 2 · this / interval times"},
      1.0);
  settings.still_speed_mps =
      config.non_negative({"still_speed_mps", "m/s", "below this speed the robot counts as standing"}, 0.05);
  settings.mounting_yaw_sigma_rad =
      kRadPerDeg * config.number_in({"mounting_yaw_sigma_deg", "°",
                                     "error of the yaw of `base_T_sensor` as a state: its first σ; 0: no state"},
                                    0.0, 45.0, 0.0);
  settings.speed_scale_sigma = config.number_in(
      {"speed_scale_sigma",
       "scale error of the speed (elevations that a planar radar does not see) as a state: its first σ; 0: no state"},
      0.0, 0.5, 0.0);
  if (config.has("rear_axle")) {
    settings.rear_axle = read_rear_axle(config.child(
        {"rear_axle", "the base's origin is the middle of an axle that does not steer; for one radar of a vehicle"}));
  }
  return settings;
}

BlockIndex RadarSettings::index() const {
  BlockIndex index;
  if (mounting_yaw_sigma_rad > 0.0) index.mounting_yaw = index.size++;
  if (speed_scale_sigma > 0.0) index.speed_scale = index.size++;
  if (rear_axle && rear_axle->slip_sigma > 0.0) index.slip = index.size++;
  return index;
}

StateBlock RadarSettings::block() const {
  StateBlock block;
  if (mounting_yaw_sigma_rad > 0.0) {
    block.emplace_back();
    block.back().name = "mounting_yaw_rad";
    block.back().initial_sigma = mounting_yaw_sigma_rad;
  }
  if (speed_scale_sigma > 0.0) {
    block.emplace_back();
    block.back().name = "speed_scale";
    block.back().initial_sigma = speed_scale_sigma;
  }
  if (rear_axle && rear_axle->slip_sigma > 0.0) {
    block.emplace_back();
    block.back().name = "slip_rad_s2_per_m";
    block.back().initial = rear_axle->slip;
    block.back().initial_sigma = rear_axle->slip_sigma;
  }
  return block;
}

}  // namespace waymark::radar
