// SPDX-License-Identifier: Apache-2.0
#include "simulated_radar.hpp"

#include <algorithm>
#include <cmath>

#include "streams.hpp"

namespace waymark::simulator {
namespace {

constexpr double kRadarPhase = 0.19;
constexpr double kPhaseStep = 0.11;
constexpr double kLeastCosine = 0.1;

/// Different for each radar, and from those of the other sensors.
double phase_of(std::size_t number) { return std::fmod(kRadarPhase + kPhaseStep * static_cast<double>(number), 1.0); }

Eigen::Vector3d ray(double azimuth, double elevation) {
  return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation)};
}

/// Uniform in (−half, half).
double within(double half, Random& random) { return half * (2.0 * random.uniform() - 1.0); }

/// Calls `draw` a Poisson number of times, by counting exponential waiting times.
template <class Function>
void poisson(double mean, Random& random, const Function& draw) {
  for (double sum = -std::log1p(-random.uniform()); sum < mean; sum -= std::log1p(-random.uniform())) draw();
}

}  // namespace

SimulatedRadar::SimulatedRadar(const Config& config, const Rig& rig, const Traffic& traffic, std::size_t number)
    : SimulatedSensor(config, RadarTargets::kType, 13.0, phase_of(number)),
      number_(static_cast<std::uint32_t>(number)),
      traffic_(traffic),
      T_base_sensor_(rig.T_base_sensor(channel().sensor)),
      range_max_m_(config.positive({"range_max_m", "m", "what is further away is not seen"}, 50.0)),
      half_view_rad_(0.5 * kDegree *
                     config.number_in({"view_deg", "°", "full width of the field of view"}, 1.0, 180.0, 120.0)),
      half_rise_rad_(
          0.5 * kDegree *
          config.number_in({"rise_deg", "°", "full height of the field of view; 0: a planar radar"}, 0.0, 120.0, 0.0)),
      rays_(config.integer_in({"rays", "rays of a scan, in directions that are drawn anew; what one meets is a target"},
                              0, 10'000, 100)),
      range_sigma_m_(config.non_negative({"range_sigma_m", "m", "white noise of each range"}, 0.1)),
      azimuth_sigma_rad_(
          kDegree * config.non_negative(
                        {"azimuth_sigma_deg", "°", "white noise of an azimuth in front; it grows with 1/cos"}, 0.3)),
      elevation_sigma_rad_(
          kDegree *
          config.non_negative({"elevation_sigma_deg", "°", "the same of an elevation; with `rise_deg`"}, 1.0)),
      radial_sigma_mps_(config.positive({"radial_sigma_mps", "m/s", "white noise of each radial velocity"}, 0.05)),
      radial_max_mps_(config.positive(
          {"radial_max_mps", "m/s", "larger radial velocities are ambiguous: they come back on the other side"}, 50.0)),
      false_alarms_(config.number_in({"false_alarms_per_scan",
                                      "mean number (Poisson) of targets that are none: range, direction and radial "
                                      "velocity uniform over what the radar measures"},
                                     0.0, 10'000.0, 0.0)),
      targets_per_thing_(config.number_in(
          {"targets_per_thing", "mean number (Poisson) of targets on each thing of the traffic in view"}, 0.0, 1000.0,
          5.0)),
      multipath_probability_(
          config.number_in({"multipath_probability",
                            "a target shows a second time at twice the range with twice the radial velocity (from "
                            "there to the robot and back once more) with this probability"},
                           0.0, 1.0, 0.0)) {}

/// One target as the radar reports it, if it is within range and view.
void SimulatedRadar::add_once(const Echo& echo, const Eigen::Vector4d& noise, RadarTargets& scan) const {
  if (echo.range_m > range_max_m_) return;
  RadarTargets::One one;
  one.range_m = std::clamp(echo.range_m + range_sigma_m_ * noise(0), 0.0, range_max_m_);
  // An array measures a phase, in proportion to the angle's sine.
  const double cosine = std::max(kLeastCosine, std::cos(echo.azimuth_rad));
  one.azimuth_rad = echo.azimuth_rad + azimuth_sigma_rad_ / cosine * noise(1);
  if (half_rise_rad_ > 0.0) {
    const double elevation_cosine = std::max(kLeastCosine, std::cos(echo.elevation_rad));
    one.elevation_rad = echo.elevation_rad + elevation_sigma_rad_ / elevation_cosine * noise(2);
  }
  one.radial_mps = std::remainder(echo.radial_mps + radial_sigma_mps_ * noise(3), 2.0 * radial_max_mps_);
  scan.targets.push_back(one);
}

/// Draws for every target, so that what one ray meets does not change the others.
void SimulatedRadar::add(const Echo& echo, bool is_visible, Random& random, RadarTargets& scan) const {
  const auto noise = [&] {
    return Eigen::Vector4d(random.normal(), random.normal(), random.normal(), random.normal());
  };
  const Eigen::Vector4d direct = noise();
  const Eigen::Vector4d bounced = noise();
  const bool bounces = random.uniform() < multipath_probability_;
  if (!is_visible) return;
  add_once(echo, direct, scan);
  if (bounces)
    add_once({2.0 * echo.range_m, echo.azimuth_rad, echo.elevation_rad, 2.0 * echo.radial_mps}, bounced, scan);
}

void SimulatedRadar::add_still(const Truth& truth, Duration time, const Pose& T_map_sensor,
                               const Eigen::Vector3d& v_sensor, RadarTargets& scan) const {
  Random random = stream(truth.seed, Draw::radar, time, number_);
  for (std::int64_t i = 0; i < rays_; ++i) {
    const double azimuth = within(half_view_rad_, random);
    const double elevation = within(half_rise_rad_, random);
    const Eigen::Vector3d direction = ray(azimuth, elevation);
    const bool in_space = half_rise_rad_ > 0.0 || !truth.world.ground.is_level();
    const double range = in_space ? truth.world.cast(T_map_sensor.p, Eigen::Vector3d(T_map_sensor.q * direction))
                                  : truth.world.cast(T_map_sensor.p, T_map_sensor.yaw() + azimuth);
    add({range, azimuth, elevation, -direction.dot(v_sensor)}, range <= range_max_m_, random, scan);
  }
}

void SimulatedRadar::add_moving(const Truth& truth, Duration time, const Pose& T_map_sensor,
                                const Eigen::Vector3d& v_sensor, RadarTargets& scan) const {
  const Pose T_sensor_map = T_map_sensor.inverse();
  const bool level = truth.world.ground.is_level();
  Random random = stream(truth.seed, Draw::traffic_echoes, time, number_);
  for (const Traffic::Thing& thing : traffic_.at(time)) {
    const Eigen::Vector3d v_thing = T_sensor_map.q * Eigen::Vector3d(thing.v_map.x(), thing.v_map.y(), 0.0);
    poisson(targets_per_thing_, random, [&] {
      const Eigen::Vector2d spread(within(Traffic::kRadius, random), within(Traffic::kRadius, random));
      const Eigen::Vector2d at = thing.p_map + spread;
      const Eigen::Vector3d p = T_sensor_map * Eigen::Vector3d(at.x(), at.y(), T_map_sensor.p.z());
      const double range = std::max(p.norm(), 1e-3);
      const double azimuth = std::atan2(p.y(), p.x());
      const double elevation = level ? 0.0 : std::asin(std::clamp(p.z() / range, -1.0, 1.0));
      const double hidden_from = level ? truth.world.cast(T_map_sensor.p, T_map_sensor.yaw() + azimuth)
                                       : truth.world.cast(T_map_sensor.p, Eigen::Vector3d(T_map_sensor.q * p / range));
      const bool is_visible = std::abs(azimuth) <= half_view_rad_ && range < hidden_from;
      add({range, azimuth, elevation, p.dot(v_thing - v_sensor) / range}, is_visible, random, scan);
    });
  }
}

void SimulatedRadar::add_false_alarms(const Truth& truth, Duration time, RadarTargets& scan) const {
  Random random = stream(truth.seed, Draw::false_alarms, time, number_);
  poisson(false_alarms_, random, [&] {
    RadarTargets::One& one = scan.targets.emplace_back();
    one.range_m = range_max_m_ * random.uniform();
    one.azimuth_rad = within(half_view_rad_, random);
    one.elevation_rad = within(half_rise_rad_, random);
    one.radial_mps = within(radial_max_mps_, random);
  });
}

std::shared_ptr<Payload> SimulatedRadar::sample(const Truth& truth, Duration time) {
  const Motion motion = truth.trajectory.at(time);
  const Pose T_map_sensor = motion.pose() * T_base_sensor_;
  const Eigen::Vector3d v_sensor = T_map_sensor.q.conjugate() * velocity(motion, T_base_sensor_.p);
  auto scan = std::make_shared<RadarTargets>();
  scan->targets.reserve(static_cast<std::size_t>(rays_));
  add_still(truth, time, T_map_sensor, v_sensor, *scan);
  add_moving(truth, time, T_map_sensor, v_sensor, *scan);
  add_false_alarms(truth, time, *scan);
  return scan;
}

}  // namespace waymark::simulator
