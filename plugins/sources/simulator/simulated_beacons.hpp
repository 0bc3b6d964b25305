// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "simulated_sensor.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::simulator {

/// Ranges from an antenna to radio beacons at known places: with a scale and an offset that all have in common, white
/// noise, and paths that are late because something stands in the way. Beacon number i is the i-th of `places_m`.
class SimulatedBeacons : public SimulatedSensor {
 public:
  explicit SimulatedBeacons(const Config& config);

 private:
  std::shared_ptr<Payload> sample(const Truth& truth, Duration time) override;
  double measure(const Truth& truth, Duration time, int beacon, const Eigen::Vector3d& p_map_antenna) const;

  std::vector<Eigen::Vector3d> places_;
  Eigen::Vector3d p_base_antenna_;
  double range_max_m_;
  double sigma_m_;
  double scale_;
  double offset_m_;
  double late_share_;
  double late_excess_m_;
  bool in_turn_;
  bool differences_;
  int next_ = 0;  // whose turn it is
};

}  // namespace waymark::simulator
