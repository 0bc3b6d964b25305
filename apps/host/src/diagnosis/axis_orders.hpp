// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

#include "watched_sensor.hpp"

namespace waymark::host::diagnosis {

/// What a part of a sensor shows in the axes of the base, by what is there: another order of axes, or other signs.
using Order = Eigen::Matrix3d;

/// All orders and signs of three axes but the right one.
std::vector<Order> wrong_orders();

/// True if what points up seems to point up.
inline bool is_about_vertical(const Order& order) { return order(2, 2) > 0.0; }

/// True if no mounting makes it: the axes are mirrored.
inline bool is_mirrored(const Order& order) { return order.col(0).cross(order.col(1)).dot(order.col(2)) < 0.0; }

/// Which columns an order concerns: "the sign of f_x_mps2 of imu". `columns`: their names, for an axis.
std::string columns_of(const WatchedSensor& sensor, const Order& order, const std::string& columns);

/// The order of some part that leaves least.
struct BestOrder {
  double left = std::numeric_limits<double>::infinity();
  Order order = Order::Identity();

  void consider(double other, const Order& of) {
    if (other < left) *this = {other, of};
  }
};

}  // namespace waymark::host::diagnosis
