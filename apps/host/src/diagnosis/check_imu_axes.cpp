// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "checks.hpp"
#include "fit.hpp"

namespace waymark::host::diagnosis {

namespace {

using Certainty = Finding::Certainty;

constexpr double kHalfWindow = 0.2;  // [s], over which the specific force is averaged
constexpr long kLeastSamples = 100;
constexpr Eigen::Index kLeastRows = 60;
constexpr double kClearlyBetter = 0.75;  // σ of what is left
constexpr double kAsGood = 1.1;          // likewise
constexpr double kHardlyTurns = 0.08;    // [rad] over a span

/// What is shown along x and y of the base by a part of an IMU whose axes are in another order, or have other signs.
struct Order {
  bool is_swapped = false;
  double sign_x = 1.0;
  double sign_y = 1.0;

  bool is_right() const { return !is_swapped && sign_x > 0.0 && sign_y > 0.0; }
  /// True if no axis is mirrored: so an IMU looks that is mounted in another direction.
  bool is_turn() const { return (sign_x == sign_y) != is_swapped; }
  Eigen::Vector2d inverted(double shown_x, double shown_y) const {
    return is_swapped ? Eigen::Vector2d(sign_y * shown_y, sign_x * shown_x)
                      : Eigen::Vector2d(sign_x * shown_x, sign_y * shown_y);
  }
};

/// The orders of both parts.
struct AxesOrder {
  Order accelerometer;
  Order gyro;
};

std::vector<Order> wrong_orders() {
  std::vector<Order> orders;
  orders.reserve(7);
  for (const bool is_swapped : {false, true}) {
    for (const double sign_x : {1.0, -1.0}) {
      for (const double sign_y : {1.0, -1.0}) {
        const Order order{is_swapped, sign_x, sign_y};
        if (!order.is_right()) orders.push_back(order);
      }
    }
  }
  return orders;
}

/// What the robot's own motion adds to the specific force over a span: how it changes, and its product with the yaw
/// rate, summed up [m/s²]. Without a way that is known: nothing, where the robot hardly turns.
struct OwnMotion {
  Eigen::Vector2d change = Eigen::Vector2d::Zero();
  Eigen::Vector2d turned = Eigen::Vector2d::Zero();
};

std::optional<OwnMotion> own_motion(const WatchedSensor& imu, const Observer* way, double t) {
  const auto turn = imu.yaw.change(t, t + kGravitySpan);
  if (!turn) return std::nullopt;
  if (way == nullptr) return std::abs(*turn) < kHardlyTurns ? std::optional(OwnMotion{}) : std::nullopt;
  const auto before = acceleration(*way->track, imu.yaw, t);
  const auto middle = acceleration(*way->track, imu.yaw, t + 0.5 * kGravitySpan);
  const auto after = acceleration(*way->track, imu.yaw, t + kGravitySpan);
  if (!before || !middle || !after) return std::nullopt;
  return OwnMotion{*after - *before, *turn * (*before + 4.0 * *middle + *after) / 6.0};
}

/// σ of the change of gravity over a span that the gyro does not explain [m/s²], with a rest value of each axis;
/// nothing if too little is known.
std::optional<double> unexplained(const WatchedSensor& imu, const AxesOrder& order, const Observer* way,
                                  double newest) {
  Rows rows(2 * (static_cast<Eigen::Index>(newest / kGravitySpan) + 1), 2);
  for (double t = 2.0 * kHalfWindow; t + kGravitySpan + kHalfWindow < newest && !rows.full(); t += kGravitySpan) {
    const auto change = gravity_change(imu, t, kHalfWindow);
    const auto own = change ? own_motion(imu, way, t) : std::nullopt;
    if (!own) continue;
    const Eigen::Vector2d seen = order.accelerometer.inverted(change->force.x(), change->force.y()) - own->change;
    const Eigen::Vector2d level = order.accelerometer.inverted(change->z_x, change->z_y) - own->turned;
    const Eigen::Vector2d tilt = order.gyro.inverted(change->x_z, change->y_z);
    const Eigen::Vector2d left = seen - Eigen::Vector2d(level.y() - tilt.y(), tilt.x() - level.x());
    for (Eigen::Index axis = 0; axis < 2; ++axis) {
      rows.A.row(rows.count).setZero();
      rows.A(rows.count, axis) = kGravitySpan;
      rows.y(rows.count++) = left(axis);
    }
  }
  if (rows.count < kLeastRows) return std::nullopt;
  const Fit fit = fit_rows(rows);
  if (!fit.valid || !(fit.residual > 0.0)) return std::nullopt;
  return fit.residual;
}

/// Which columns an order concerns: "the sign of f_x_mps2".
std::string columns_of(const WatchedSensor& sensor, const Order& order, const std::string& columns) {
  const auto column = [&](const Eigen::Vector3d& axis) {
    return fmt::format(fmt::runtime(columns), axis_along(sensor, axis));
  };
  const std::string x = column(Eigen::Vector3d::UnitX());
  const std::string y = column(Eigen::Vector3d::UnitY());
  if (order.is_swapped) return fmt::format("the order or the signs of {} and {}", std::min(x, y), std::max(x, y));
  if (order.sign_x < 0.0 && order.sign_y < 0.0)
    return fmt::format("the signs of {} and {}", std::min(x, y), std::max(x, y));
  return "the sign of " + (order.sign_x < 0.0 ? x : y);
}

/// The order of some part that leaves least.
struct Best {
  double left = std::numeric_limits<double>::infinity();
  Order order;

  void consider(const std::optional<double>& other, const Order& of) {
    if (other && *other < left) *this = {*other, of};
  }
};

void check_imu(Case& c, std::size_t i, const Observer* way) {
  const WatchedSensor& imu = c.sensor(i);
  const auto left = [&](const AxesOrder& order) { return unexplained(imu, order, way, c.watch.newest()); };
  const auto as_it_is = left({});
  if (!as_it_is) return;
  Best accelerometer;
  Best gyro;
  Best both;
  for (const Order& order : wrong_orders()) {
    accelerometer.consider(left({order, {}}), order);
    gyro.consider(left({{}, order}), order);
    if (order.is_turn()) both.consider(left({order, order}), order);
  }
  const double least = std::min(accelerometer.left, gyro.left);
  // One that is mounted in another direction shows it in its accelerations.
  if (least > kClearlyBetter * *as_it_is || both.left < kAsGood * least) return;
  std::string change;
  if (accelerometer.left < kAsGood * least) change = columns_of(imu, accelerometer.order, "f_{}_mps2");
  if (gyro.left < kAsGood * least) {
    if (!change.empty()) change += ", or ";
    change += columns_of(imu, gyro.order, "w_{}_radps");
  }
  c.add(Certainty::named, "gravity", {i},
        fmt::format("gravity in its specific force does not turn as its gyro does: {:.2g} m/s² beside it each second, "
                    "{:.2g} with other axes",
                    *as_it_is, least),
        fmt::format("source: {} of {}", change, imu.name), 0.0);
}

}  // namespace

void check_imu_axes(Case& c, const MotionAgreement& motion) {
  const Observer* way = motion.way.trusted_track();
  if (way != nullptr && c.is_concerned(way->sensor)) way = nullptr;
  for (std::size_t i = 0; i < c.watch.sensors().size(); ++i) {
    if (c.sensor(i).gravity_turns.x_z.samples() >= kLeastSamples && !c.is_concerned(i)) check_imu(c, i, way);
  }
}

}  // namespace waymark::host::diagnosis
