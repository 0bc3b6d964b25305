// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "axis_orders.hpp"
#include "watched_sensor.hpp"

namespace waymark::host::diagnosis {

/// How the axes of a gyro and of a magnetometer lie to each other, where they fit only with others than those of the
/// YAML.
struct FieldTurns {
  double as_it_is = 0.0;     ///< σ of the field's change that the gyro does not explain [T]
  double left = 0.0;         ///< likewise, with other axes
  bool is_about_z = false;   ///< one of both is turned about the vertical axis, or the field's z has the other sign
  double angle = 0.0;        ///< then: by which the gyro would have to be turned [rad]
  double angle_sigma = 0.0;  ///< likewise
  double scale = 1.0;        ///< if not 1: so many times as far as the field the gyro turns
  double scale_sigma = 0.0;
  bool is_open = false;            ///< otherwise: a mirrored gyro and another order of the field fit alike
  Order gyro = Order::Identity();  ///< what the gyro shows, by what would fit
};

/// The Earth's field stays in the world, so it turns in the robot as its gyro does, only to the other side. Nothing if
/// it does, or if too little is known.
std::optional<FieldTurns> field_turns(const WatchedSensor& magnetometer, const WatchedSensor& imu, double newest);

/// True if the gyro shows that the field's vertical axis has the right sign.
bool confirms_vertical(const WatchedSensor& magnetometer, const WatchedSensor& imu, double newest);

/// A field that turns with the robot, in its plane [T].
struct Iron {
  double value = 0.0;
  double sigma = 0.0;
};

/// Nothing if no gyro of three axes shows it.
std::optional<Iron> iron_of(const WatchedSensor& magnetometer, const WatchedSensor& imu, double newest);

}  // namespace waymark::host::diagnosis
