// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "simulated_sensor.hpp"
#include "traffic.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/interface/rig.hpp"
#include "waymark/math/random.hpp"

namespace waymark::simulator {

/// A radar that measures range, direction and radial velocity of what its rays meet, each scan in other directions, and
/// of traffic. With false alarms, and with echoes that bounce twice between a target and the robot.
class SimulatedRadar : public SimulatedSensor {
 public:
  static constexpr std::size_t kMost = 10;  ///< radars of one robot: their phases and draws differ

  /// `number` is that among the robot's radars, from 0. `traffic` must outlive the radar.
  SimulatedRadar(const Config& config, const Rig& rig, const Traffic& traffic, std::size_t number);

 private:
  /// What a target is, without noise.
  struct Echo {
    double range_m;
    double azimuth_rad;
    double elevation_rad;
    double radial_mps;
  };

  std::shared_ptr<Payload> sample(const Truth& truth, Duration time) override;
  void add_still(const Truth& truth, Duration time, const Pose& T_map_sensor, const Eigen::Vector3d& v_sensor,
                 RadarTargets& scan) const;
  void add_moving(const Truth& truth, Duration time, const Pose& T_map_sensor, const Eigen::Vector3d& v_sensor,
                  RadarTargets& scan) const;
  void add_false_alarms(const Truth& truth, Duration time, RadarTargets& scan) const;
  void add(const Echo& echo, bool is_visible, Random& random, RadarTargets& scan) const;
  void add_once(const Echo& echo, const Eigen::Vector4d& noise, RadarTargets& scan) const;

  std::uint32_t number_;
  const Traffic& traffic_;
  Pose T_base_sensor_;
  double range_max_m_;
  double half_view_rad_;
  double half_rise_rad_;
  std::int64_t rays_;
  double range_sigma_m_;
  double azimuth_sigma_rad_;
  double elevation_sigma_rad_;
  double radial_sigma_mps_;
  double radial_max_mps_;
  double false_alarms_;
  double targets_per_thing_;
  double multipath_probability_;
};

}  // namespace waymark::simulator
