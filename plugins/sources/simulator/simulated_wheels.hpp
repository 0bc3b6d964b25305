// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "simulated_sensor.hpp"
#include "windows.hpp"

namespace waymark::simulator {

/// Differential drive: speeds of the wheels at the stamp, with scale errors, white noise, and spans of time in which
/// both wheels spin (or slide).
class SimulatedWheels : public SimulatedSensor {
 public:
  explicit SimulatedWheels(const Config& config);

 private:
  std::shared_ptr<Payload> sample(const Truth& truth, Duration time) override;

  double track_m_;
  double noise_m_per_sqrt_s_;
  double left_scale_;
  double right_scale_;
  double scale_sigma_;
  double spin_ratio_;
  Windows spins_;
};

}  // namespace waymark::simulator
