// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "axis_orders.hpp"
#include "checks.hpp"
#include "fit.hpp"
#include "observers.hpp"

namespace waymark::host::diagnosis {

namespace {

using Certainty = Finding::Certainty;

constexpr double kHalfWindow = 0.2;  // [s], over which the specific force is averaged
constexpr long kLeastSamples = 100;
constexpr std::size_t kLeastSpans = 30;
constexpr double kClearlyBetter = 0.75;   // σ of what is left
constexpr double kAsGood = 1.1;           // likewise
constexpr double kLeastExplained = 0.05;  // [m/s²], more than a robot on a level floor shows
constexpr double kHardlyTurns = 0.08;     // [rad] over a span

/// The orders of both parts.
struct AxesOrder {
  Order accelerometer = Order::Identity();
  Order gyro = Order::Identity();
};

/// What the robot's own motion adds to the specific force over a span: how it changes, and its product with the yaw
/// rate, summed up [m/s²]. Without a way that is known: nothing, where the robot hardly turns.
struct OwnMotion {
  Eigen::Vector2d change = Eigen::Vector2d::Zero();
  Eigen::Vector2d turned = Eigen::Vector2d::Zero();
};

std::optional<OwnMotion> own_motion(const Observer* way, const Track& yaw, double t) {
  const auto turn = yaw.change(t, t + kVectorSpan);
  if (!turn) return std::nullopt;
  if (way == nullptr) return std::abs(*turn) < kHardlyTurns ? std::optional(OwnMotion{}) : std::nullopt;
  const auto before = acceleration(*way->track, yaw, t);
  const auto middle = acceleration(*way->track, yaw, t + 0.5 * kVectorSpan);
  const auto after = acceleration(*way->track, yaw, t + kVectorSpan);
  if (!before || !middle || !after) return std::nullopt;
  return OwnMotion{*after - *before, *turn * (*before + 4.0 * *middle + *after) / 6.0};
}

/// Changes over the spans in which all is known, and what the robot's own motion has of them.
struct Spans {
  std::vector<TurnedVector> changes;
  std::vector<OwnMotion> own;
};

/// `way` may be null. Nothing of a gyro that measures its yaw rate alone.
Spans gravity_spans(const WatchedSensor& imu, const Observer* way, const Track& yaw, double newest) {
  Spans spans;
  std::size_t still = 0;
  for (double t = 2.0 * kHalfWindow; t + kVectorSpan + kHalfWindow < newest; t += kVectorSpan) {
    const auto change = turned_vector(imu.turn, imu.force, t, kHalfWindow);
    const auto own = change ? own_motion(way, yaw, t) : std::nullopt;
    if (!own) continue;
    spans.changes.push_back(*change);
    spans.own.push_back(*own);
    if (change->products(0, 2) == 0.0 && change->products(1, 2) == 0.0) ++still;
  }
  return 2 * still > spans.changes.size() ? Spans{} : spans;
}

/// What the parts would show with the axes in the right order.
TurnedVector reordered(const TurnedVector& shown, const AxesOrder& order) {
  return {order.accelerometer.transpose() * shown.change, order.gyro.transpose() * shown.products * order.accelerometer,
          order.accelerometer.transpose() * shown.sum, order.gyro.transpose() * shown.turn};
}

/// σ of the change of gravity over a span that the gyro does not explain [m/s²], beside a rest value of each axis.
double unexplained(const Spans& spans, const AxesOrder& order) {
  std::array<std::vector<double>, 2> left;
  for (std::vector<double>& axis : left) axis.reserve(spans.changes.size());
  for (std::size_t k = 0; k < spans.changes.size(); ++k) {
    TurnedVector change = reordered(spans.changes[k], order);
    change.change.head<2>() -= spans.own[k].change;
    change.products.row(2).head<2>() -= spans.own[k].turned.transpose();
    const Eigen::Vector3d rest = change.change - change.by_turn();
    left[0].push_back(rest.x());
    left[1].push_back(rest.y());
  }
  std::vector<double> sizes;
  sizes.reserve(2 * spans.changes.size());
  for (std::vector<double>& axis : left) {
    const double bias = median(axis);
    for (const double value : axis) sizes.push_back(std::abs(value - bias));
  }
  return kMadToSigma * median(sizes);
}

/// The spans in which the robot turns: of one that does so now and then, half of all spans show little.
Spans turning(const Spans& spans) {
  constexpr double kTurning = 0.1;  // [rad]
  Spans some;
  for (std::size_t k = 0; k < spans.changes.size(); ++k) {
    if (spans.changes[k].turn.norm() < kTurning) continue;
    some.changes.push_back(spans.changes[k]);
    some.own.push_back(spans.own[k]);
  }
  return some;
}

void check_imu(Case& c, std::size_t i, const Spans& spans) {
  if (spans.changes.size() < kLeastSpans) return;
  const WatchedSensor& imu = c.sensor(i);
  const auto left = [&](const AxesOrder& order) { return unexplained(spans, order); };
  const double as_it_is = left({});
  BestOrder accelerometer;
  BestOrder gyro;
  BestOrder both;
  for (const Order& order : wrong_orders()) {
    gyro.consider(left({.gyro = order}), order);
    if (!is_about_vertical(order)) continue;  // which way is up, gravity itself shows
    accelerometer.consider(left({.accelerometer = order}), order);
    if (!is_mirrored(order)) both.consider(left({order, order}), order);
  }
  const double least = std::min(accelerometer.left, gyro.left);
  // One that is mounted in another direction shows it in its accelerations.
  if (least > kClearlyBetter * as_it_is || both.left < kAsGood * least) return;
  if (as_it_is * as_it_is - least * least < kLeastExplained * kLeastExplained) return;
  std::string change;
  if (accelerometer.left < kAsGood * least) change = columns_of(imu, accelerometer.order, "f_{}_mps2");
  if (gyro.left < kAsGood * least) {
    if (!change.empty()) change += ", or ";
    change += columns_of(imu, gyro.order, "w_{}_radps");
  }
  c.add(Certainty::named, "gravity", {i},
        fmt::format("gravity in its specific force does not turn as its gyro does: {:.2g} m/s² beside it each second, "
                    "{:.2g} with other axes",
                    as_it_is, least),
        fmt::format("source: {}", change), 0.0);
}

}  // namespace

void check_imu_axes(Case& c, const MotionAgreement& motion) {
  const Observer* way = motion.trusted_way(c);
  if (way != nullptr && c.is_concerned(way->sensor)) way = nullptr;
  const Observer* yaw = motion.yaw.trusted_track();
  for (std::size_t i = 0; i < c.watch.sensors().size(); ++i) {
    const WatchedSensor& imu = c.sensor(i);
    if (imu.turn.samples() < kLeastSamples || c.is_concerned(i)) continue;
    const bool is_own = yaw == nullptr || c.is_concerned(yaw->sensor);
    const Spans spans = gravity_spans(imu, way, is_own ? imu.yaw : *yaw->track, c.watch.newest());
    check_imu(c, i, spans);
    // What flies turns where it accelerates, too.
    if (!c.is_concerned(i) && measured_way(c.watch) != nullptr) check_imu(c, i, turning(spans));
  }
}

}  // namespace waymark::host::diagnosis
