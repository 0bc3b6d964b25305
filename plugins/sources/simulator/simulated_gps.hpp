// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>

#include "simulated_sensor.hpp"
#include "waymark/interface/payloads.hpp"
#include "windows.hpp"

namespace waymark::simulator {

/// Fixes of an antenna in the map's frame, with white noise, a first-order Gauss–Markov offset, and an offset that
/// jumps when the satellites change. It can fail as receivers do: gross outliers that it does not report, spans in
/// which it repeats itself or its fixes creep away.
class SimulatedGps : public SimulatedSensor {
 public:
  explicit SimulatedGps(const Config& config);

 private:
  std::shared_ptr<Payload> sample(const Truth& truth, Duration time) override;
  void change_satellites(std::uint64_t seed, Duration time, bool first);
  double degradation() const;
  GnssFix measure(const Truth& truth, Duration time, const Eigen::Vector3d& white) const;
  Eigen::Vector3d drift(std::uint64_t seed, Duration time) const;
  Eigen::Vector3d outlier(std::uint64_t seed, Duration time) const;

  Eigen::Vector3d p_base_antenna_;
  double sigma_m_;
  double sigma_up_m_;
  double correlated_sigma_m_;
  double correlation_time_s_;
  double satellite_change_mean_s_;  // 0: never
  double jump_sigma_m_;
  double speed_sigma_mps_;  // 0: the receiver reports no velocity
  double outlier_probability_;
  double outlier_max_m_;
  double drift_mps_;
  Windows outages_;
  Windows frozen_;
  Windows drifts_;
  Eigen::Vector3d offset_{0.0, 0.0, 0.0};  // east, north, up [m]; drawn from its stationary law with the first sample
  Eigen::Vector3d jump_{0.0, 0.0, 0.0};    // until the satellites change [m]
  int satellites_ = -1;                    // -1: not simulated
  GnssFix last_;                           // of which a frozen receiver cannot let go; type none: there is none yet
};

}  // namespace waymark::simulator
