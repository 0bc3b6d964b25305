// SPDX-License-Identifier: Apache-2.0
#include "simulated_inertial.hpp"

#include <algorithm>
#include <cmath>

#include "streams.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::simulator {
namespace {

constexpr double kGravity = 9.80665;  // [m/s²]
constexpr double kImuPhase = 0.13;
constexpr double kCompassPhase = 0.71;
constexpr Duration kDifference = Trajectory::kStep;  // half the span of the differences that give accelerations

Eigen::Vector3d normal3(Random& random) {
  const double x = random.normal();
  const double y = random.normal();
  return {x, y, random.normal()};
}

/// Acceleration in the map of a point of the base.
Eigen::Vector3d acceleration(const Trajectory& trajectory, Duration time, const Eigen::Vector3d& p_base) {
  const Duration before = std::max(time - kDifference, Duration{0});
  const Duration after = time + kDifference;
  const Eigen::Vector3d change = velocity(trajectory.at(after), p_base) - velocity(trajectory.at(before), p_base);
  return change / to_seconds(after - before);
}

}  // namespace

void SimulatedImu::Axes::walk(bool first, double period_s, Random& random) {
  const Eigen::Vector3d n = normal3(random);
  if (first) {
    bias = bias_start * n;
  } else {
    bias += bias_walk * std::sqrt(period_s) * n;
  }
}

SimulatedImu::SimulatedImu(const Config& config, const Rig& rig, const Magnetism& magnetism)
    : SimulatedSensor(config, ImuSample::kType, 100.0, kImuPhase),
      T_base_sensor_(rig.T_base_sensor(channel().sensor)),
      magnetism_(magnetism),
      gyroscope_{
          config.non_negative(
              {"gyroscope_noise_radps_per_sqrt_hz", "rad/s/√Hz", "white noise; σ of one sample is this times √rate"},
              2e-4),
          config.non_negative({"gyroscope_bias_sigma_radps", "rad/s", "σ of the bias at the start, each axis"}, 2e-3),
          config.non_negative({"gyroscope_bias_walk_radps_per_sqrt_s", "rad/s/√s", "random walk of the bias"}, 2e-5)},
      accelerometer_{
          config.non_negative(
              {"accelerometer_noise_mps2_per_sqrt_hz", "m/s²/√Hz", "white noise; σ of one sample is this times √rate"},
              2e-3),
          config.non_negative({"accelerometer_bias_sigma_mps2", "m/s²", "σ of the bias at the start, each axis"}, 0.03),
          config.non_negative({"accelerometer_bias_walk_mps2_per_sqrt_s", "m/s²/√s", "random walk of the bias"}, 3e-4)},
      has_magnetometer_(config.boolean({"magnetometer", "false: six axes, the field is NaN"}, true)),
      magnetometer_noise_t_(config.non_negative({"magnetometer_noise_t", "T", "σ of one sample"}, 3e-7)) {}

std::shared_ptr<Payload> SimulatedImu::sample(const Truth& truth, Duration time) {
  const bool first = time < from_seconds(period_s());
  Random walks = stream(truth.seed, Draw::bias, time);
  gyroscope_.walk(first, period_s(), walks);
  accelerometer_.walk(first, period_s(), walks);

  const Motion motion = truth.trajectory.at(time);
  const Pose T_map_sensor = motion.pose() * T_base_sensor_;
  const Eigen::Quaterniond q_sensor_map = T_map_sensor.q.conjugate();
  const Eigen::Vector3d force =
      acceleration(truth.trajectory, time, T_base_sensor_.p) + Eigen::Vector3d(0.0, 0.0, kGravity);
  Random random = stream(truth.seed, Draw::imu, time);
  const double per_sample = 1.0 / std::sqrt(period_s());
  auto imu = std::make_shared<ImuSample>();
  imu->w_sensor = q_sensor_map * motion.w_map() + gyroscope_.bias + gyroscope_.noise * per_sample * normal3(random);
  imu->f_sensor = q_sensor_map * force + accelerometer_.bias + accelerometer_.noise * per_sample * normal3(random);
  const Eigen::Vector3d noise = magnetometer_noise_t_ * normal3(random);
  if (has_magnetometer_) imu->m_sensor = q_sensor_map * magnetism_.field(T_map_sensor.p, motion.pose().q, time) + noise;
  return imu;
}

SimulatedCompass::SimulatedCompass(const Config& config, const Rig& rig, const Magnetism& magnetism)
    : SimulatedSensor(config, CompassHeading::kType, 10.0, kCompassPhase),
      T_base_sensor_(rig.T_base_sensor(channel().sensor)),
      magnetism_(magnetism),
      sigma_rad_(kDegree * config.non_negative({"sigma_deg", "°", "white noise"}, 1.0)),
      offset_rad_(kDegree *
                  config.number_in({"offset_deg", "°", "constant, as from a careless mounting"}, -180.0, 180.0, 0.0)) {}

std::shared_ptr<Payload> SimulatedCompass::sample(const Truth& truth, Duration time) {
  const Motion motion = truth.trajectory.at(time);
  const Pose T_map_sensor = motion.pose() * T_base_sensor_;
  const Eigen::Vector3d field = magnetism_.field(T_map_sensor.p, motion.pose().q, time);
  const double magnetic_north = std::atan2(field.y(), field.x());
  Random random = stream(truth.seed, Draw::compass, time);
  auto compass = std::make_shared<CompassHeading>();
  compass->heading_rad = so3::wrap(magnetic_north - T_map_sensor.yaw() + offset_rad_ + sigma_rad_ * random.normal());
  return compass;
}

}  // namespace waymark::simulator
