// SPDX-License-Identifier: Apache-2.0
#include "simulated_sensors.hpp"

#include <cmath>

#include "streams.hpp"
#include "waymark/payloads.hpp"

namespace waymark::simulator {
namespace {

/// First samples in periods. Odd shares, so that at the usual rates no two sensors measure at the same time.
constexpr double kWheelsPhase = 0.0;
constexpr double kGpsPhase = 0.31;

constexpr int kFewestSatellites = 4;
constexpr int kMostSatellites = 11;
constexpr int kSatellitesForCorrections = 6;
constexpr double kWithoutCorrections = 3.0;
constexpr double kHdopOfOneSpare = 4.0;  // of the fewest satellites; it falls as there are more

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
      right_scale_(1.0 + config.number_in("scale_error_right", -0.5, 0.5, 0.0)),
      spin_ratio_(config.number_in("spin_ratio", -1.0, 10.0, 0.3)),
      spins_(config, "spins_s") {}

std::shared_ptr<const Payload> SimulatedWheels::sample(const Truth& truth, Duration stamp) {
  const Motion motion = truth.trajectory.at(stamp);
  Random random = stream(truth.seed, Draw::wheels, stamp);
  const double sigma = noise_m_per_sqrt_s_ / std::sqrt(period_s());
  const double spin = spins_.contain(stamp) ? 1.0 + spin_ratio_ : 1.0;
  // A wheel that stands gives no pulses, so it has no noise either.
  const auto measured = [&](double true_mps, double scale) {
    const double noise = sigma * random.normal();
    return true_mps == 0.0 ? 0.0 : scale * spin * true_mps + noise;
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
      correlation_time_s_(config.positive("correlation_time_s", 60.0)),
      satellite_change_mean_s_(config.non_negative("satellite_change_mean_s", 0.0)),
      jump_sigma_m_(config.non_negative("jump_sigma_m", 0.5)),
      outages_(config, "outages_s") {}

/// At random times the receiver takes other satellites, and its error jumps to another constant.
void SimulatedGps::change_satellites(std::uint64_t seed, Duration stamp, bool first) {
  Random random = stream(seed, Draw::satellites, stamp);
  const bool changes = random.uniform() < -std::expm1(-period_s() / satellite_change_mean_s_);
  if (!changes && !first) return;
  satellites_ = kFewestSatellites + static_cast<int>((kMostSatellites - kFewestSatellites + 1) * random.uniform());
  for (double& jump : jump_) jump = jump_sigma_m_ * degradation() * random.normal();
}

/// How many times larger all errors are without the reference station's corrections, which take enough satellites.
double SimulatedGps::degradation() const {
  return satellites_ >= 0 && satellites_ < kSatellitesForCorrections ? kWithoutCorrections : 1.0;
}

std::shared_ptr<const Payload> SimulatedGps::sample(const Truth& truth, Duration stamp) {
  const bool first = stamp < from_seconds(period_s());
  if (satellite_change_mean_s_ > 0.0) change_satellites(truth.seed, stamp, first);
  const double sigma = degradation() * sigma_m_;
  const double sigma_up = degradation() * sigma_up_m_;
  Random random = stream(truth.seed, Draw::gps, stamp);
  const Eigen::Vector3d white(sigma * random.normal(), sigma * random.normal(), sigma_up * random.normal());
  // x' = φ x + σ √(1 − φ²) n keeps the variance σ²; φ = 0 draws the first value. The offset lives on in an outage.
  const double phi = first ? 0.0 : std::exp(-period_s() / correlation_time_s_);
  const double drive_sigma = correlated_sigma_m_ * std::sqrt(1.0 - phi * phi);
  for (double& offset : offset_) offset = phi * offset + drive_sigma * random.normal();
  if (outages_.contain(stamp)) return nullptr;
  auto fix = std::make_shared<GnssFix>();
  fix->p_map_antenna = truth.trajectory.at(stamp).pose() * p_base_antenna_ + offset_ + jump_ + white;
  fix->sigma_horizontal_m = sigma;
  fix->sigma_vertical_m = sigma_up;
  fix->type = degradation() > 1.0 ? GnssFix::Type::single : GnssFix::Type::differential;
  if (satellites_ >= 0) {
    fix->satellites = satellites_;
    fix->hdop = kHdopOfOneSpare / std::pow(satellites_ - kFewestSatellites + 1, 0.8);
  }
  return fix;
}

void SimulatedGps::save_state(OutArchive& archive) const {
  archive.value(offset_);
  archive.value(jump_);
  archive.value(satellites_);
}

void SimulatedGps::load_state(InArchive& archive) {
  archive.value(offset_);
  archive.value(jump_);
  archive.value(satellites_);
}

}  // namespace waymark::simulator
