// SPDX-License-Identifier: Apache-2.0
#include "simulated_gps.hpp"

#include <cmath>
#include <numbers>

#include "streams.hpp"

namespace waymark::simulator {
namespace {

constexpr double kGpsPhase = 0.31;

constexpr int kFewestSatellites = 4;
constexpr int kMostSatellites = 11;
constexpr int kSatellitesForCorrections = 6;
constexpr double kWithoutCorrections = 3.0;
constexpr double kHdopOfOneSpare = 4.0;  // of the fewest satellites; it falls as there are more

}  // namespace

SimulatedGps::SimulatedGps(const Config& config)
    : SimulatedSensor(config, GnssFix::kType, 5.0, kGpsPhase),
      p_base_antenna_(Eigen::Vector3d::Map(
          config.numbers({"base_p_antenna_m", "m", "antenna in the base frame"}, 3, {0.0, 0.0, 0.0}).data())),
      sigma_m_(config.positive({"sigma_m", "m", "white noise of east and north; the fix reports it"}, 0.3)),
      sigma_up_m_(config.positive({"sigma_up_m", "m", "white noise of the height", "2 × sigma_m"}, 2.0 * sigma_m_)),
      correlated_sigma_m_(config.non_negative(
          {"correlated_sigma_m", "m", "slowly varying offset (first-order Gauss–Markov), each axis; 0: none"}, 0.0)),
      correlation_time_s_(config.positive({"correlation_time_s", "s", "correlation time of that offset"}, 60.0)),
      satellite_change_mean_s_(
          config.non_negative({"satellite_change_mean_s", "s",
                               "mean time until the satellites change; 0: never, and the fix reports no satellites"},
                              0.0)),
      jump_sigma_m_(config.non_negative(
          {"jump_sigma_m", "m", "each change draws a new constant offset of this σ, each axis"}, 0.5)),
      speed_sigma_mps_(config.has("speed_sigma_mps")
                           ? config.positive({"speed_sigma_mps", "m/s",
                                              "white noise of the velocity over ground, east and north; with this key "
                                              "the fix reports speed and course of the antenna",
                                              "none"})
                           : 0.0),
      outlier_probability_(config.number_in({"outlier_probability",
                                             "share of gross outliers: off in any direction, the distance uniform up "
                                             "to `outlier_max_m`; the fix reports its usual σ"},
                                            0.0, 1.0, 0.0)),
      outlier_max_m_(config.positive({"outlier_max_m", "m", "largest distance of a gross outlier"}, 800.0)),
      drift_mps_(config.positive({"drift_mps", "m/s", "how fast the fix creeps away"}, 0.5)),
      outages_(config, {"outages_s", "s", "begin, end of one outage after the other, one flat list"}),
      frozen_(config,
              {"frozen_s", "s",
               "begin, end of spans in which the receiver repeats its last fix, velocity and all, with new stamps"}),
      drifts_(config,
              {"drift_s", "s", "begin, end of spans in which the fix creeps away, in each into another direction"}) {
  last_.type = GnssFix::Type::none;
}

/// At random times the receiver takes other satellites, and its error jumps to another constant.
void SimulatedGps::change_satellites(std::uint64_t seed, Duration time, bool first) {
  Random random = stream(seed, Draw::satellites, time);
  const bool changes = random.uniform() < -std::expm1(-period_s() / satellite_change_mean_s_);
  if (!changes && !first) return;
  satellites_ = kFewestSatellites + static_cast<int>((kMostSatellites - kFewestSatellites + 1) * random.uniform());
  for (double& jump : jump_) jump = jump_sigma_m_ * degradation() * random.normal();
}

/// How many times larger all errors are without the reference station's corrections, which take enough satellites.
double SimulatedGps::degradation() const {
  return satellites_ >= 0 && satellites_ < kSatellitesForCorrections ? kWithoutCorrections : 1.0;
}

/// How far the fix has crept away: in each span into another direction.
Eigen::Vector3d SimulatedGps::drift(std::uint64_t seed, Duration time) const {
  const auto begin = drifts_.begin(time);
  if (!begin) return Eigen::Vector3d::Zero();
  const double direction = 2.0 * std::numbers::pi * stream(seed, Draw::drift, *begin).uniform();
  const double distance = drift_mps_ * to_seconds(time - *begin);
  return {distance * std::cos(direction), distance * std::sin(direction), 0.0};
}

Eigen::Vector3d SimulatedGps::outlier(std::uint64_t seed, Duration time) const {
  Random random = stream(seed, Draw::outliers, time);
  if (random.uniform() >= outlier_probability_) return Eigen::Vector3d::Zero();
  const double direction = 2.0 * std::numbers::pi * random.uniform();
  const double distance = outlier_max_m_ * random.uniform();
  return {distance * std::cos(direction), distance * std::sin(direction), 0.0};
}

GnssFix SimulatedGps::measure(const Truth& truth, Duration time, const Eigen::Vector3d& white) const {
  const Motion motion = truth.trajectory.at(time);
  GnssFix fix;
  fix.p_map_antenna =
      motion.pose() * p_base_antenna_ + offset_ + jump_ + white + drift(truth.seed, time) + outlier(truth.seed, time);
  fix.sigma_horizontal_m = degradation() * sigma_m_;
  fix.sigma_vertical_m = degradation() * sigma_up_m_;
  fix.type = degradation() > 1.0 ? GnssFix::Type::single : GnssFix::Type::differential;
  if (satellites_ >= 0) {
    fix.satellites = satellites_;
    fix.hdop = kHdopOfOneSpare / std::pow(satellites_ - kFewestSatellites + 1, 0.8);
  }
  if (speed_sigma_mps_ > 0.0) {
    Random random = stream(truth.seed, Draw::doppler, time);
    const double sigma = degradation() * speed_sigma_mps_;
    Eigen::Vector2d v_map = velocity(motion, p_base_antenna_).head<2>();
    for (double& component : v_map) component += sigma * random.normal();
    fix.speed_mps = v_map.norm();
    fix.course_rad = std::atan2(v_map.x(), v_map.y());
  }
  return fix;
}

std::shared_ptr<Payload> SimulatedGps::sample(const Truth& truth, Duration time) {
  const bool first = time < from_seconds(period_s());
  if (satellite_change_mean_s_ > 0.0) change_satellites(truth.seed, time, first);
  const double sigma = degradation() * sigma_m_;
  const double sigma_up = degradation() * sigma_up_m_;
  Random random = stream(truth.seed, Draw::gps, time);
  const Eigen::Vector3d white(sigma * random.normal(), sigma * random.normal(), sigma_up * random.normal());
  // x' = φ x + σ √(1 − φ²) n keeps the variance σ²; φ = 0 draws the first value. The offset lives on in an outage.
  const double phi = first ? 0.0 : std::exp(-period_s() / correlation_time_s_);
  const double drive_sigma = correlated_sigma_m_ * std::sqrt(1.0 - phi * phi);
  for (double& offset : offset_) offset = phi * offset + drive_sigma * random.normal();
  if (outages_.contain(time)) return nullptr;
  const bool stuck = frozen_.contain(time) && last_.type != GnssFix::Type::none;
  if (!stuck) last_ = measure(truth, time, white);
  return std::make_shared<GnssFix>(last_);
}

}  // namespace waymark::simulator
