// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/calibration/standing.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "apps/waymark/calibration/log_reader.hpp"
#include "apps/waymark/calibration/parameter.hpp"
#include "waymark/base/error.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/interface/sensor.hpp"

namespace waymark::calibration {

namespace {

constexpr double kLeastStandSeconds = 20.0;
constexpr double kStillRate = 0.02;           // [rad/s], spread within a second: MEMS devices at rest have less
constexpr double kStillForce = 0.15;          // [m/s²], likewise
constexpr double kSameRate = 0.005;           // [rad/s], of the means of two seconds in sequence
constexpr double kMotionMps = 0.01;           // as `still_speed_mps` of the odometry
constexpr double kMotionRadps = 0.01;         // as `still_rate_radps`
constexpr std::size_t kFewestSamples = 5;     // of a second
constexpr double kUsualGyroNoise = 8.727e-4;  // [rad/√s], the default of the plugin imu
constexpr double kUsualGravity = 9.81;        // [m/s²], likewise

/// The samples of one second.
struct Second {
  std::size_t begin;
  std::size_t end;
  Eigen::Vector3d rate;  // mean
  bool is_still;
};

Eigen::Vector3d mean(const std::vector<InertialSample>& samples, std::size_t begin, std::size_t end,
                     Eigen::Vector3d InertialSample::*field) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = begin; i < end; ++i) sum += samples[i].*field;
  return sum / static_cast<double>(end - begin);
}

/// Largest standard deviation of the axes; NaN if one is not known.
double spread(const std::vector<InertialSample>& samples, std::size_t begin, std::size_t end,
              Eigen::Vector3d InertialSample::*field) {
  const Eigen::Vector3d middle = mean(samples, begin, end, field);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = begin; i < end; ++i) sum += (samples[i].*field - middle).cwiseAbs2();
  const Eigen::Vector3d variance = sum / static_cast<double>(end - begin - 1);
  return variance.allFinite() ? std::sqrt(variance.maxCoeff()) : std::nan("");
}

std::vector<Second> seconds_of(const std::vector<InertialSample>& samples, const std::vector<Time>& moving) {
  std::vector<Second> seconds;
  for (std::size_t begin = 0; begin < samples.size();) {
    const Time until = samples[begin].stamp + from_seconds(1.0);
    std::size_t end = begin;
    while (end < samples.size() && samples[end].stamp < until) ++end;
    Second second{begin, end, Eigen::Vector3d::Zero(), end - begin >= kFewestSamples};
    if (second.is_still) {
      second.rate = mean(samples, begin, end, &InertialSample::rate);
      const auto next_motion = std::ranges::lower_bound(moving, samples[begin].stamp);
      // A force that is not measured (NaN) contradicts nothing.
      second.is_still = spread(samples, begin, end, &InertialSample::rate) < kStillRate &&
                        !(spread(samples, begin, end, &InertialSample::force) > kStillForce) &&
                        (next_motion == moving.end() || *next_motion >= until);
    }
    seconds.push_back(second);
    begin = end;
  }
  return seconds;
}

std::vector<double> axis_of(const std::vector<InertialSample>& samples, std::size_t begin, std::size_t end,
                            Eigen::Vector3d InertialSample::*field, int axis) {
  std::vector<double> values;
  values.reserve(end - begin);
  for (std::size_t i = begin; i < end; ++i) values.push_back((samples[i].*field)(axis));
  return values;
}

/// The length of the mean force: along it a bias is observable, across it a bias is a tilt.
void read_force(const std::vector<InertialSample>& samples, std::size_t first, std::size_t last, Standing& standing) {
  const Eigen::Vector3d force = mean(samples, first, last, &InertialSample::force);
  standing.force_base = force;  // turned by who knows the mounting
  standing.force_norm = force.norm();
  if (!force.allFinite()) return;
  const Eigen::Vector3d along = force.normalized();
  double variance = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double white = white_noise(standing.force[axis]).density / std::sqrt(standing.duration_s);
    const double sigma = std::hypot(white, lowest(standing.force[axis]).deviation);
    variance += along(axis) * along(axis) * sigma * sigma;
  }
  standing.force_norm_sigma = std::sqrt(variance);
}

}  // namespace

std::optional<Standing> standing_of(const std::vector<InertialSample>& samples, const std::vector<Time>& moving) {
  const std::vector<Second> seconds = seconds_of(samples, moving);
  std::size_t best_begin = 0;
  std::size_t best_end = 0;
  std::size_t begin = 0;
  for (std::size_t i = 0; i < seconds.size(); ++i) {
    const bool continues = seconds[i].is_still &&
                           (i == begin || (seconds[i].rate - seconds[i - 1].rate).cwiseAbs().maxCoeff() < kSameRate);
    if (!continues) begin = seconds[i].is_still ? i : i + 1;
    if (i + 1 > begin && i + 1 - begin > best_end - best_begin) {
      best_begin = begin;
      best_end = i + 1;
    }
  }
  // The first and the last one may have caught the beginning of a motion.
  if (best_end - best_begin < static_cast<std::size_t>(kLeastStandSeconds) + 2) return std::nullopt;
  const std::size_t first = seconds[best_begin + 1].begin;
  const std::size_t last = seconds[best_end - 2].end;
  Standing standing;
  standing.duration_s = to_seconds(samples[last - 1].stamp - samples[first].stamp);
  const double period_s = standing.duration_s / static_cast<double>(last - 1 - first);
  standing.rate_hz = 1.0 / period_s;
  standing.begin_s = to_seconds(samples[first].stamp - samples.front().stamp);
  standing.bias = mean(samples, first, last, &InertialSample::rate);
  const bool has_force = samples[first].force.allFinite();
  for (int axis = 0; axis < 3; ++axis) {
    standing.gyro[axis] = allan_deviation(axis_of(samples, first, last, &InertialSample::rate, axis), period_s);
    if (has_force)
      standing.force[axis] = allan_deviation(axis_of(samples, first, last, &InertialSample::force, axis), period_s);
    const WhiteNoise noise = white_noise(standing.gyro[axis]);
    standing.noise.density += noise.density * noise.density / 3.0;
    standing.noise.sigma += noise.sigma * noise.sigma / 9.0;
    // The mean over the stretch is no surer than the bias stays.
    standing.bias_sigma(axis) =
        std::hypot(noise.density / std::sqrt(standing.duration_s), lowest(standing.gyro[axis]).deviation);
  }
  read_force(samples, first, last, standing);
  standing.noise.density = std::sqrt(standing.noise.density);
  standing.noise.sigma = std::sqrt(standing.noise.sigma);
  return standing;
}

std::vector<Standing> standing_over_log(const std::filesystem::path& yaml,
                                        const std::vector<Config::Override>& overrides, std::optional<double> until_s,
                                        const std::vector<std::string>& imus) {
  LogReader log(yaml, overrides, until_s);
  const host::Robot& robot = log.robot();
  std::vector<std::vector<InertialSample>> samples(robot.sensors.size());
  std::vector<Time> moving;
  while (std::optional<Measurement> m = log.next()) {
    const SensorSlot& slot = robot.sensors[m->sensor];
    if (m->payload->type() == ImuSample::kType) {
      const auto& imu = m->as<ImuSample>();
      if (imu.w_sensor.allFinite()) samples[m->sensor].push_back({m->stamp, imu.w_sensor, imu.f_sensor});
      continue;
    }
    if (slot.sensor == nullptr) continue;
    try {
      const std::optional<ObservedMotion> seen = slot.sensor->observed_motion(*m, nullptr);
      if (seen && (std::abs(seen->speed_mps) > kMotionMps || std::abs(seen->yaw_rate_radps) > kMotionRadps))
        moving.push_back(m->stamp);
    } catch (const DataError&) {
      continue;  // the filter counts it
    }
  }
  std::ranges::sort(moving);
  std::vector<Standing> all;
  for (std::size_t i = 0; i < robot.sensors.size(); ++i) {
    if (std::ranges::find(imus, robot.sensors[i].name) == imus.end()) continue;
    std::ranges::stable_sort(samples[i], {}, &InertialSample::stamp);
    std::optional<Standing> standing = standing_of(samples[i], moving);
    if (!standing) continue;
    standing->sensor = robot.sensors[i].name;
    standing->begin_s += to_seconds(samples[i].front().stamp - log.first().value());
    for (const Config& sensor : robot.yaml.items("sensors")) {
      if (sensor.text("name") != standing->sensor) continue;
      standing->given_noise = sensor.number(kGyroNoise, kUsualGyroNoise);
      standing->given_gravity = sensor.number(kGravity, kUsualGravity);
    }
    standing->force_base = robot.rig.T_base_sensor(standing->sensor).q * standing->force_base;
    all.push_back(std::move(*standing));
  }
  return all;
}

}  // namespace waymark::calibration
