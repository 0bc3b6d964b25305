// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "simulated_sensor.hpp"
#include "waymark/interface/rig.hpp"
#include "world.hpp"

namespace waymark::simulator {

/// A scanner with several rings of beams, each a cone around its z axis, mounted in any orientation. It sees the
/// ground, a ceiling, and all that stands in the world, up to its height. The cloud holds what came back, column after
/// column, each from the lowest ring up.
class SimulatedLidar3d : public SimulatedSensor {
 public:
  SimulatedLidar3d(const Config& config, const Rig& rig, const World& world);

 private:
  std::shared_ptr<Payload> sample(const Truth& truth, Duration time) override;

  Pose T_base_sensor_;
  double range_max_m_;
  double sigma_m_;
  double sweep_s_;
  std::size_t rings_;
  std::size_t columns_;
  std::vector<Eigen::Vector3d> directions_;  // unit vectors in the sensor's frame, in the order of the cloud
};

}  // namespace waymark::simulator
