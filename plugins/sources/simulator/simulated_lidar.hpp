// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "simulated_sensor.hpp"
#include "waymark/interface/rig.hpp"
#include "waymark/math/random.hpp"
#include "world.hpp"

namespace waymark::simulator {

/// A laser scanner, level in the base, that sees the cylinders, all beams at one instant or one after the other. In
/// each scan a cylinder may be missing, and things may stand there that the next scan does not see again. A beam has a
/// width, so at an edge it meets fore- and background at once.
class SimulatedLidar : public SimulatedSensor {
 public:
  SimulatedLidar(const Config& config, const Rig& rig);

 private:
  std::shared_ptr<Payload> sample(const Truth& truth, Duration time) override;
  World seen(const Truth& truth, Duration stamp, const Pose& T_map_sensor) const;
  double measured(const World& world, const Pose& T_map_sensor, double angle_rad, Random& mixing) const;

  Pose T_base_sensor_;
  double range_max_m_;
  double start_rad_;
  double step_rad_;
  int beams_;
  double beam_interval_s_;
  double sigma_m_;
  double miss_probability_;
  double clutter_per_scan_;
  double beam_width_rad_;
  double mixed_probability_;
  double edge_m_;
};

}  // namespace waymark::simulator
