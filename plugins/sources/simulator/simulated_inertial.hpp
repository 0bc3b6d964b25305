// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>

#include "magnetism.hpp"
#include "simulated_sensor.hpp"
#include "waymark/interface/rig.hpp"
#include "waymark/math/random.hpp"

namespace waymark::simulator {

/// Nine axes: gyroscopes, accelerometers and magnetometers, each with white noise, and the first two with biases that
/// start at random and walk.
class SimulatedImu : public SimulatedSensor {
 public:
  /// `magnetism` must outlive the sensor.
  SimulatedImu(const Config& config, const Rig& rig, const Magnetism& magnetism);

 private:
  /// The errors of three equal axes.
  struct Axes {
    double noise;       ///< density of the white noise [unit/√Hz]
    double bias_start;  ///< sigma of the first bias [unit]
    double bias_walk;   ///< density of its random walk [unit/√s]
    Eigen::Vector3d bias{0.0, 0.0, 0.0};

    void walk(bool first, double period_s, Random& random);
  };

  std::shared_ptr<Payload> sample(const Truth& truth, Duration time) override;

  Pose T_base_sensor_;
  const Magnetism& magnetism_;
  Axes gyroscope_;
  Axes accelerometer_;
  bool has_magnetometer_;
  double magnetometer_noise_t_;
};

/// A compass that measures only the direction of the horizontal part of the field.
class SimulatedCompass : public SimulatedSensor {
 public:
  /// `magnetism` must outlive the sensor.
  SimulatedCompass(const Config& config, const Rig& rig, const Magnetism& magnetism);

 private:
  std::shared_ptr<Payload> sample(const Truth& truth, Duration time) override;

  Pose T_base_sensor_;
  const Magnetism& magnetism_;
  double sigma_rad_;
  double offset_rad_;
};

}  // namespace waymark::simulator
