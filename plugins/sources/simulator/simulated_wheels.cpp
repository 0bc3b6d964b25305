// SPDX-License-Identifier: Apache-2.0
#include "simulated_wheels.hpp"

#include <cmath>

#include "streams.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::simulator {
namespace {

constexpr double kWheelsPhase = 0.0;

}  // namespace

SimulatedWheels::SimulatedWheels(const Config& config)
    : SimulatedSensor(config, WheelSpeeds::kType, 40.0, kWheelsPhase),
      track_m_(config.positive({"track_m", "m", "between left and right wheel"})),
      noise_m_per_sqrt_s_(config.positive(
          {"noise_m_per_sqrt_s", "m/√s", "density of each wheel's white noise; a standing wheel has none"}, 0.01)),
      left_scale_(1.0 + config.number_in({"scale_error_left", "measured = (1 + error) · true, of the left wheel"}, -0.5,
                                         0.5, 0.0)),
      right_scale_(1.0 + config.number_in({"scale_error_right", "measured = (1 + error) · true, of the right wheel"},
                                          -0.5, 0.5, 0.0)),
      scale_sigma_(config.number_in(
          {"scale_error_sigma", "σ of a further scale error of each wheel, drawn once from the source's seed"}, 0.0,
          0.1, 0.0)),
      spin_ratio_(
          config.number_in({"spin_ratio", "wheels that slip turn faster by this share; -1: they slide without turning"},
                           -1.0, 10.0, 0.3)),
      spins_(config, {"spins_s", "s", "begin, end of spans in which both wheels slip on the ground"}) {}

std::shared_ptr<Payload> SimulatedWheels::sample(const Truth& truth, Duration time) {
  const Motion motion = truth.trajectory.at(time);
  const double v = motion.v_base().x();
  const double w = motion.w_base().z();
  Random random = stream(truth.seed, Draw::wheels, time);
  const double sigma = noise_m_per_sqrt_s_ / std::sqrt(period_s());
  Random sizes = stream(truth.seed, Draw::wheel_sizes, Duration{});
  const double left_scale = left_scale_ + scale_sigma_ * sizes.normal();
  const double right_scale = right_scale_ + scale_sigma_ * sizes.normal();
  const double spin = spins_.contain(time) ? 1.0 + spin_ratio_ : 1.0;
  // A wheel that stands gives no pulses, so it has no noise either.
  const auto measured = [&](double true_mps, double scale) {
    const double noise = sigma * random.normal();
    return true_mps == 0.0 ? 0.0 : scale * spin * true_mps + noise;
  };
  auto speeds = std::make_shared<WheelSpeeds>();
  speeds->left_mps = measured(v - 0.5 * track_m_ * w, left_scale);
  speeds->right_mps = measured(v + 0.5 * track_m_ * w, right_scale);
  return speeds;
}

}  // namespace waymark::simulator
