// SPDX-License-Identifier: Apache-2.0
#include "simulated_sensors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "streams.hpp"
#include "waymark/payloads.hpp"

namespace waymark::simulator {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

/// First samples in periods. Odd shares, so that at the usual rates no two sensors measure at the same time.
constexpr double kWheelsPhase = 0.0;
constexpr double kGpsPhase = 0.31;
constexpr double kLidarPhase = 0.57;

}  // namespace

SimulatedSensor::SimulatedSensor(const Config& config, std::string_view payload_type, double default_rate_hz,
                                 double phase)
    : channel_{config.text("sensor"), std::string(payload_type)},
      rate_hz_(config.number_in("rate_hz", 0.001, 10000.0, default_rate_hz)),
      phase_(phase),
      delay_(from_seconds(config.number_in("delay_s", 0.0, 60.0, 0.0))) {}

Duration SimulatedSensor::next_stamp() const { return from_seconds((static_cast<double>(taken_) + phase_) / rate_hz_); }

std::shared_ptr<const Payload> SimulatedSensor::take(const Truth& truth) {
  auto payload = sample(truth, next_stamp());
  ++taken_;
  return payload;
}

void SimulatedSensor::save(OutArchive& archive) const {
  archive.value(taken_);
  save_state(archive);
}

void SimulatedSensor::load(InArchive& archive) {
  archive.value(taken_);
  load_state(archive);
}

SimulatedWheels::SimulatedWheels(const Config& config)
    : SimulatedSensor(config, WheelSpeeds::kType, 40.0, kWheelsPhase),
      track_m_(config.positive("track_m")),
      noise_m_per_sqrt_s_(config.positive("noise_m_per_sqrt_s", 0.01)),
      left_scale_(1.0 + config.number_in("scale_error_left", -0.5, 0.5, 0.0)),
      right_scale_(1.0 + config.number_in("scale_error_right", -0.5, 0.5, 0.0)) {}

std::shared_ptr<const Payload> SimulatedWheels::sample(const Truth& truth, Duration stamp) {
  const Motion motion = truth.trajectory.at(stamp);
  Random random = stream(truth.seed, Draw::wheels, stamp);
  const double sigma = noise_m_per_sqrt_s_ / std::sqrt(period_s());
  // A wheel that stands gives no pulses, so it has no noise either.
  const auto measured = [&](double true_mps, double scale) {
    const double noise = sigma * random.normal();
    return true_mps == 0.0 ? 0.0 : scale * true_mps + noise;
  };
  auto speeds = std::make_shared<WheelSpeeds>();
  speeds->left_mps = measured(motion.v_x - 0.5 * track_m_ * motion.w, left_scale_);
  speeds->right_mps = measured(motion.v_x + 0.5 * track_m_ * motion.w, right_scale_);
  return speeds;
}

SimulatedGps::SimulatedGps(const Config& config)
    : SimulatedSensor(config, GnssFix::kType, 5.0, kGpsPhase),
      p_base_antenna_(Eigen::Vector3d::Map(config.numbers("base_p_antenna_m", 3, {0.0, 0.0, 0.0}).data())),
      sigma_m_(config.positive("sigma_m", 0.3)),
      sigma_up_m_(config.positive("sigma_up_m", 2.0 * sigma_m_)),
      correlated_sigma_m_(config.non_negative("correlated_sigma_m", 0.0)),
      correlation_time_s_(config.positive("correlation_time_s", 60.0)) {
  const std::vector<double> times = config.numbers("outages_s", -1, {});
  if (times.size() % 2 != 0) {
    config.fail("outages_s", fmt::format("{} numbers; begin and end of each outage are expected", times.size()));
  }
  for (std::size_t i = 0; i < times.size(); i += 2) {
    if (!(times[i] >= 0.0 && times[i] < times[i + 1] && times[i + 1] < 1e9)) {
      config.fail("outages_s",
                  fmt::format("an outage from {} to {} s; 0 <= begin < end is expected", times[i], times[i + 1]));
    }
    outages_.emplace_back(from_seconds(times[i]), from_seconds(times[i + 1]));
  }
}

std::shared_ptr<const Payload> SimulatedGps::sample(const Truth& truth, Duration stamp) {
  Random random = stream(truth.seed, Draw::gps, stamp);
  const Eigen::Vector3d white(sigma_m_ * random.normal(), sigma_m_ * random.normal(), sigma_up_m_ * random.normal());
  // x' = φ x + σ √(1 − φ²) n keeps the variance σ²; φ = 0 draws the first value. The offset lives on in an outage.
  const bool first = stamp < from_seconds(period_s());
  const double phi = first ? 0.0 : std::exp(-period_s() / correlation_time_s_);
  const double drive_sigma = correlated_sigma_m_ * std::sqrt(1.0 - phi * phi);
  for (double& offset : offset_) offset = phi * offset + drive_sigma * random.normal();
  if (std::ranges::any_of(outages_,
                          [&](const auto& outage) { return outage.first <= stamp && stamp < outage.second; })) {
    return nullptr;
  }
  auto fix = std::make_shared<GnssFix>();
  fix->p_map_antenna = truth.trajectory.at(stamp).pose() * p_base_antenna_ + offset_ + white;
  fix->sigma_horizontal_m = sigma_m_;
  fix->sigma_vertical_m = sigma_up_m_;
  fix->type = GnssFix::Type::differential;
  return fix;
}

SimulatedLidar::SimulatedLidar(const Config& config, const Rig& rig)
    : SimulatedSensor(config, LaserScan::kType, 5.0, kLidarPhase),
      T_base_sensor_(rig.T_base_sensor(channel().sensor)),
      range_max_m_(config.positive("range_max_m", 30.0)),
      start_rad_(kDegree * config.number_in("start_deg", -360.0, 360.0, -135.0)),
      step_rad_(kDegree * config.positive("step_deg", 0.5)),
      beams_(static_cast<int>(config.integer_in("beams", 1, 100000, 541))),
      sigma_m_(config.positive("sigma_m", 0.02)),
      miss_probability_(config.number_in("miss_probability", 0.0, 1.0, 0.0)),
      clutter_per_scan_(config.number_in("clutter_per_scan", 0.0, 1000.0, 0.0)) {
  const Eigen::Vector3d rpy = so3::to_rpy(T_base_sensor_.q);
  if (std::hypot(rpy.x(), rpy.y()) > 1e-9) {
    config.fail("sensor", fmt::format("base_T_sensor of '{}' has roll or pitch; the simulated scanner is horizontal",
                                      channel().sensor));
  }
}

/// The world of one scan: without the cylinders that it misses, with its clutter.
World SimulatedLidar::seen(const Truth& truth, Duration stamp, const Pose& T_map_sensor) const {
  World world = truth.world;
  Random misses = stream(truth.seed, Draw::misses, stamp);
  std::erase_if(world.landmarks, [&](const Cylinder&) { return misses.uniform() < miss_probability_; });
  // Poisson by counting exponential waiting times.
  Random clutter = stream(truth.seed, Draw::clutter, stamp);
  constexpr double kNearest = 1.0;
  for (double sum = -std::log1p(-clutter.uniform()); sum < clutter_per_scan_; sum -= std::log1p(-clutter.uniform())) {
    const double range = kNearest + (range_max_m_ - kNearest) * clutter.uniform();
    const double bearing = start_rad_ + step_rad_ * (beams_ - 1) * clutter.uniform();
    const Eigen::Vector3d p = T_map_sensor * Eigen::Vector3d(range * std::cos(bearing), range * std::sin(bearing), 0.0);
    world.stones.push_back({p.head<2>(), 0.05 + 0.25 * clutter.uniform(), World::kNothing});
  }
  return world;
}

std::shared_ptr<const Payload> SimulatedLidar::sample(const Truth& truth, Duration stamp) {
  const Pose T_map_sensor = truth.trajectory.at(stamp).pose() * T_base_sensor_;
  const bool as_it_is = miss_probability_ == 0.0 && clutter_per_scan_ == 0.0;
  const World disturbed = as_it_is ? World{} : seen(truth, stamp, T_map_sensor);
  const World& world = as_it_is ? truth.world : disturbed;
  Random random = stream(truth.seed, Draw::lidar, stamp);
  auto scan = std::make_shared<LaserScan>();
  scan->start_rad = start_rad_;
  scan->step_rad = step_rad_;
  scan->ranges_m.reserve(static_cast<std::size_t>(beams_));
  for (int beam = 0; beam < beams_; ++beam) {
    const double noise = sigma_m_ * random.normal();
    const double range = world.cast(T_map_sensor.p, T_map_sensor.yaw() + start_rad_ + beam * step_rad_);
    const double shown = range > range_max_m_ ? range_max_m_ + 1.0 : std::clamp(range + noise, 0.0, range_max_m_);
    scan->ranges_m.push_back(static_cast<float>(shown));
  }
  return scan;
}

}  // namespace waymark::simulator
