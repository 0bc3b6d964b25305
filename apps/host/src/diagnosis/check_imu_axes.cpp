// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <array>
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
constexpr double kClearlyBetter = 0.75;   // σ of what is left
constexpr double kAsGood = 1.1;           // likewise
constexpr double kLeastExplained = 0.05;  // [m/s²], more than a robot on a level floor shows
constexpr double kHardlyTurns = 0.08;     // [rad] over a span

/// What a part of an IMU shows in the axes of the base, by what is there: another order of axes, or other signs.
using Order = Eigen::Matrix3d;

/// The orders of both parts.
struct AxesOrder {
  Order accelerometer = Order::Identity();
  Order gyro = Order::Identity();
};

/// All orders and signs of three axes but the right one.
std::vector<Order> wrong_orders() {
  std::vector<Order> orders;
  orders.reserve(47);
  std::array<Eigen::Index, 3> axes{0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Order order = Order::Zero();
      for (Eigen::Index i = 0; i < 3; ++i)
        order(i, axes[static_cast<std::size_t>(i)]) = ((signs >> i) & 1) != 0 ? -1.0 : 1.0;
      if (!order.isIdentity()) orders.push_back(order);
    }
  } while (std::ranges::next_permutation(axes).found);
  return orders;
}

bool is_about_vertical(const Order& order) { return order(2, 2) > 0.0; }

/// What the robot's own motion adds to the specific force over a span: how it changes, and its product with the yaw
/// rate, summed up [m/s²]. Without a way that is known: nothing, where the robot hardly turns.
struct OwnMotion {
  Eigen::Vector2d change = Eigen::Vector2d::Zero();
  Eigen::Vector2d turned = Eigen::Vector2d::Zero();
};

std::optional<OwnMotion> own_motion(const Observer* way, const Track& yaw, double t) {
  const auto turn = yaw.change(t, t + kGravitySpan);
  if (!turn) return std::nullopt;
  if (way == nullptr) return std::abs(*turn) < kHardlyTurns ? std::optional(OwnMotion{}) : std::nullopt;
  const auto before = acceleration(*way->track, yaw, t);
  const auto middle = acceleration(*way->track, yaw, t + 0.5 * kGravitySpan);
  const auto after = acceleration(*way->track, yaw, t + kGravitySpan);
  if (!before || !middle || !after) return std::nullopt;
  return OwnMotion{*after - *before, *turn * (*before + 4.0 * *middle + *after) / 6.0};
}

/// Where the robot's own motion comes from: the way may be null.
struct OwnSources {
  const Observer* way;
  const Track& yaw;
};

/// True if the gyro measures its yaw rate alone.
bool has_one_axis(const WatchedSensor& imu, double newest) {
  long spans = 0;
  long still = 0;
  for (double t = kHalfWindow; t + kGravitySpan + kHalfWindow < newest; t += kGravitySpan) {
    const auto change = gravity_change(imu, t, kHalfWindow);
    if (!change) continue;
    ++spans;
    if (change->products(0, 2) == 0.0 && change->products(1, 2) == 0.0) ++still;
  }
  return 2 * still > spans;
}

/// σ of the change of gravity over a span that the gyro does not explain [m/s²], with a rest value of each axis;
/// nothing if too little is known.
std::optional<double> unexplained(const WatchedSensor& imu, const AxesOrder& order, const OwnSources& sources,
                                  double newest) {
  Rows rows(2 * (static_cast<Eigen::Index>(newest / kGravitySpan) + 1), 2);
  for (double t = 2.0 * kHalfWindow; t + kGravitySpan + kHalfWindow < newest && !rows.full(); t += kGravitySpan) {
    auto change = gravity_change(imu, t, kHalfWindow);
    const auto own = change ? own_motion(sources.way, sources.yaw, t) : std::nullopt;
    if (!own) continue;
    change->force = order.accelerometer.topLeftCorner<2, 2>().transpose() * change->force - own->change;
    change->products = order.gyro.transpose() * change->products * order.accelerometer;
    change->products.row(2).head<2>() -= own->turned.transpose();
    const Eigen::Vector2d left = change->force - change->by_turn();
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

/// Which columns an order concerns: "the sign of f_x_mps2". `columns`: their names, for an axis.
std::string columns_of(const WatchedSensor& sensor, const Order& order, const std::string& columns) {
  std::vector<std::string> names;
  for (Eigen::Index i = 0; i < 3; ++i) {
    if (order(i, i) <= 0.0)
      names.push_back(fmt::format(fmt::runtime(columns), axis_along(sensor, Order::Identity().col(i))));
  }
  std::ranges::sort(names);
  const bool is_sign = order.cwiseAbs().isIdentity();
  return fmt::format("{} of {}",
                     !is_sign           ? "the order or the signs"
                     : names.size() > 1 ? "the signs"
                                        : "the sign",
                     fmt::join(names, " and "));
}

/// The order of some part that leaves least.
struct Best {
  double left = std::numeric_limits<double>::infinity();
  Order order = Order::Identity();

  void consider(const std::optional<double>& other, const Order& of) {
    if (other && *other < left) *this = {*other, of};
  }
};

void check_imu(Case& c, std::size_t i, const OwnSources& sources) {
  const WatchedSensor& imu = c.sensor(i);
  const auto left = [&](const AxesOrder& order) { return unexplained(imu, order, sources, c.watch.newest()); };
  const auto as_it_is = left({});
  if (!as_it_is) return;
  Best accelerometer;
  Best gyro;
  Best both;
  for (const Order& order : wrong_orders()) {
    gyro.consider(left({.gyro = order}), order);
    if (!is_about_vertical(order)) continue;  // which way is up, gravity itself shows
    accelerometer.consider(left({.accelerometer = order}), order);
    if (order.determinant() > 0.0) both.consider(left({order, order}), order);
  }
  const double least = std::min(accelerometer.left, gyro.left);
  // One that is mounted in another direction shows it in its accelerations.
  if (least > kClearlyBetter * *as_it_is || both.left < kAsGood * least) return;
  if (*as_it_is * *as_it_is - least * least < kLeastExplained * kLeastExplained) return;
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
  const Observer* way = motion.trusted_way(c);
  if (way != nullptr && c.is_concerned(way->sensor)) way = nullptr;
  const Observer* yaw = motion.yaw.trusted_track();
  for (std::size_t i = 0; i < c.watch.sensors().size(); ++i) {
    const WatchedSensor& imu = c.sensor(i);
    if (imu.gravity_turns.samples() < kLeastSamples || c.is_concerned(i) || has_one_axis(imu, c.watch.newest()))
      continue;
    const bool is_own = yaw == nullptr || c.is_concerned(yaw->sensor);
    check_imu(c, i, {way, is_own ? imu.yaw : *yaw->track});
  }
}

}  // namespace waymark::host::diagnosis
