// SPDX-License-Identifier: Apache-2.0
#include "field_turns.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "checks.hpp"
#include "fit.hpp"

namespace waymark::host::diagnosis {

namespace {

constexpr double kHalfWindow = 0.1;  // [s], over which the field is averaged
constexpr long kLeastSamples = 100;
constexpr std::size_t kLeastSpans = 30;
constexpr double kTurning = 0.1;            // [rad] over a span
constexpr double kClearlyBetter = 0.75;     // σ of what is left
constexpr double kAsGood = 1.1;             // likewise
constexpr double kLeastExplained = 0.1e-6;  // [T], less changes no heading by a degree
constexpr double kVague = 8.0 * kDegree;
constexpr double kOtherScale = 0.4;  // logarithm of the scale of a gyro, which no gyro has by itself
constexpr double kSameScale = 0.2;   // likewise, of both axes in the plane
constexpr double kScaleShare = 0.1;  // σ of a scale that is known, as a share
constexpr double kWhole = 0.3;       // logarithm of the scale of turns that are whole

using Spans = std::vector<TurnedVector>;

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d matrix;
  matrix << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return matrix;
}

/// ∫ ω × v dt of the products ∫ ω vᵀ dt.
Eigen::Vector3d cross_of(const Eigen::Matrix3d& products) { return -TurnedVector{{}, products, {}, {}}.by_turn(); }

/// Nothing of a gyro that measures its yaw rate alone.
Spans spans_of(const WatchedSensor& magnetometer, const WatchedSensor& imu, double newest) {
  Spans spans;
  if (magnetometer.field.samples() < kLeastSamples || imu.turn.samples() < kLeastSamples) return spans;
  std::size_t still = 0;
  for (double t = 2.0 * kHalfWindow; t + kVectorSpan + kHalfWindow < newest; t += kVectorSpan) {
    const auto span = turned_vector(imu.turn, magnetometer.field, t, kHalfWindow);
    if (!span) continue;
    spans.push_back(*span);
    if (span->turn.x() == 0.0 && span->turn.y() == 0.0) ++still;
  }
  return spans.size() < kLeastSpans || 2 * still > spans.size() ? Spans{} : spans;
}

/// Three rows a span: what iron (columns 0 to 2) and a rest value of the gyro (3 to 5) make of the field's change
/// beside the turns, and `columns` more.
Rows rows_of(const Spans& spans, Eigen::Index columns) {
  Rows rows(3 * static_cast<Eigen::Index>(spans.size()), 6 + columns);
  for (const TurnedVector& span : spans) {
    auto block = rows.A.middleRows(rows.count, 3);
    block.leftCols<3>() = cross_matrix(span.turn);
    block.middleCols<3>(3) = -cross_matrix(span.sum);
    rows.y.segment<3>(rows.count) = span.change;
    rows.count += 3;
  }
  return rows;
}

Spans with_gyro(const Spans& shown, const Order& order) {
  Spans spans = shown;
  for (TurnedVector& span : spans) {
    span.products = order.transpose() * span.products;
    span.turn = order.transpose() * span.turn;
  }
  return spans;
}

Fit fit_of(const Spans& spans) {
  Rows rows = rows_of(spans, 0);
  for (std::size_t k = 0; k < spans.size(); ++k)
    rows.y.segment<3>(3 * static_cast<Eigen::Index>(k)) -= spans[k].by_turn();
  return fit_rows(rows);
}

/// σ of the field's change that the gyro does not explain, with its axes in another order [T].
double left_with(const Spans& spans, const Order& order) {
  const Fit fit = fit_of(with_gyro(spans, order));
  return fit.valid ? fit.residual : std::numeric_limits<double>::infinity();
}

/// The same with any linear relation between the rates and those of the gyro: nothing leaves less.
double least_left(const Spans& spans) {
  Rows rows = rows_of(spans, 9);
  for (std::size_t k = 0; k < spans.size(); ++k) {
    for (Eigen::Index i = 0; i < 3; ++i) {
      for (Eigen::Index j = 0; j < 3; ++j) {
        Eigen::Matrix3d of_axis = Eigen::Matrix3d::Zero();
        of_axis.row(i) = spans[k].products.row(j);
        rows.A.block<3, 1>(3 * static_cast<Eigen::Index>(k), 6 + 3 * i + j) = -cross_of(of_axis);
      }
    }
  }
  const Fit fit = fit_rows(rows);
  return fit.valid ? fit.residual : std::numeric_limits<double>::infinity();
}

struct YawFit {
  double angle;
  double sigma;
  double scale;
};

Order turned_by(double angle) {
  // What a gyro shows that would have to be turned by an angle.
  Order order = Order::Identity();
  order.topLeftCorner<2, 2>() << std::cos(angle), std::sin(angle), -std::sin(angle), std::cos(angle);
  return order;
}

/// How many times as far as the field the gyro turns, whatever the field's scale is.
struct ScaleFit {
  double scale;
  double sigma;
  double left;  ///< σ of the field's change [T]
};

/// The same by one axis of the field alone; 0 if it is not known.
double scale_of_axis(const Spans& spans, Eigen::Index axis) {
  Rows rows(static_cast<Eigen::Index>(spans.size()), 2);
  for (const TurnedVector& span : spans) {
    rows.A.row(rows.count) << span.by_turn()(axis), 1.0;
    rows.y(rows.count++) = span.change(axis);
  }
  const Fit fit = fit_rows(rows);
  return fit.valid && fit.x(0) > 0.0 ? 1.0 / fit.x(0) : 0.0;
}

/// A robust fit follows one axis, where a magnetometer has another scale on one of them.
bool is_of_both_axes(const Spans& spans, double scale) {
  const auto is_near = [&](double other) { return other > 0.0 && std::abs(std::log(other / scale)) < kSameScale; };
  return is_near(scale_of_axis(spans, 0)) && is_near(scale_of_axis(spans, 1));
}

std::optional<ScaleFit> fit_scale(const Spans& spans) {
  Rows rows = rows_of(spans, 1);
  for (std::size_t k = 0; k < spans.size(); ++k)
    rows.A.block<3, 1>(3 * static_cast<Eigen::Index>(k), 6) = spans[k].by_turn();
  const Fit fit = fit_rows(rows);
  if (!fit.valid || !(fit.x(6) > 0.0)) return std::nullopt;
  return ScaleFit{1.0 / fit.x(6), fit.sigma(6) / (fit.x(6) * fit.x(6)), fit.residual};
}

/// The turn about z of what the gyro shows with which it fits, linear in its cosine and sine.
std::optional<YawFit> fit_yaw_once(const Spans& spans) {
  Rows rows = rows_of(spans, 2);
  for (std::size_t k = 0; k < spans.size(); ++k) {
    const Eigen::Index row = 3 * static_cast<Eigen::Index>(k);
    const Eigen::Matrix3d& shown = spans[k].products;
    Eigen::Matrix3d level = shown;
    level.row(2).setZero();
    Eigen::Matrix3d crosswise = Eigen::Matrix3d::Zero();
    crosswise.row(0) = -shown.row(1);
    crosswise.row(1) = shown.row(0);
    Eigen::Matrix3d vertical = shown - level;
    rows.A.block<3, 1>(row, 6) = -cross_of(level);
    rows.A.block<3, 1>(row, 7) = -cross_of(crosswise);
    rows.y.segment<3>(row) += cross_of(vertical);
  }
  const Fit fit = fit_rows(rows);
  if (!fit.valid) return std::nullopt;
  const double scale = std::hypot(fit.x(6), fit.x(7));
  if (!(scale > 0.0)) return std::nullopt;
  return YawFit{std::atan2(fit.x(7), fit.x(6)), std::max(fit.sigma(6), fit.sigma(7)) / scale, scale};
}

/// Twice, since iron is that of the gyro's axes at first.
std::optional<YawFit> fit_yaw(const Spans& spans) {
  const auto first = fit_yaw_once(spans);
  if (!first) return std::nullopt;
  auto rest = fit_yaw_once(with_gyro(spans, turned_by(first->angle)));
  if (rest) rest->angle = std::remainder(first->angle + rest->angle, 2.0 * std::numbers::pi);
  return rest;
}

bool is_known(const YawFit& yaw) { return yaw.sigma < kVague && std::abs(std::log(yaw.scale)) < kWhole; }

/// What is left with the best order of each kind: no other order leaves as little, or its kind is not known.
struct Orders {
  BestOrder mirrored;
  BestOrder about_z;
  BestOrder other;
};

Orders best_orders(const Spans& spans) {
  Orders best;
  for (const Order& order : wrong_orders()) {
    BestOrder& kind = is_mirrored(order) ? best.mirrored : is_about_vertical(order) ? best.about_z : best.other;
    kind.consider(left_with(spans, order), order);
  }
  return best;
}

std::optional<FieldTurns> turns_of(const Spans& spans) {
  FieldTurns turns;
  turns.as_it_is = left_with(spans, Order::Identity());
  const auto is_clear = [&](double left) {
    return left < kClearlyBetter * turns.as_it_is &&
           turns.as_it_is * turns.as_it_is - left * left > kLeastExplained * kLeastExplained;
  };
  if (!std::isfinite(turns.as_it_is) || !is_clear(least_left(spans))) return std::nullopt;
  const auto scale = fit_scale(spans);
  const auto is_other_scale = [&](const ScaleFit& fit) {
    return std::abs(std::log(fit.scale)) > kOtherScale && fit.sigma < kScaleShare * fit.scale &&
           is_of_both_axes(spans, fit.scale);
  };
  const Orders best = best_orders(spans);
  const double least = std::min({best.mirrored.left, best.about_z.left, best.other.left});
  if (scale && is_other_scale(*scale) && is_clear(scale->left) && scale->left < kAsGood * least) {
    turns.left = scale->left;
    turns.scale = scale->scale;
    turns.scale_sigma = scale->sigma;
    return turns;
  }
  // Turned by any angle: simpler than mirrored axes, or than several signs.
  const auto yaw = fit_yaw(spans);
  if (yaw && is_known(*yaw)) {
    turns.left = left_with(spans, turned_by(yaw->angle));
    turns.is_about_z = is_clear(turns.left) && turns.left < kAsGood * least;
    turns.angle = yaw->angle;
    turns.angle_sigma = yaw->sigma;
    if (turns.is_about_z) return turns;
  }
  const BestOrder& kind = best.mirrored.left < best.other.left ? best.mirrored : best.other;
  const double rival = std::min(std::max(best.mirrored.left, best.other.left), best.about_z.left);
  if (!is_clear(kind.left) || best.about_z.left < kAsGood * kind.left) return std::nullopt;
  turns.is_open = rival < kAsGood * kind.left;
  turns.left = kind.left;
  turns.gyro = kind.order;
  return turns;
}

}  // namespace

std::optional<FieldTurns> field_turns(const WatchedSensor& magnetometer, const WatchedSensor& imu, double newest) {
  Spans spans = spans_of(magnetometer, imu, newest);
  if (spans.empty()) return std::nullopt;
  if (auto turns = turns_of(spans)) return turns;
  // Of a robot that turns now and then, turns are what a robust fit leaves out.
  std::erase_if(spans, [](const TurnedVector& span) { return span.turn.norm() < kTurning; });
  return spans.size() < kLeastSpans ? std::nullopt : turns_of(spans);
}

bool confirms_vertical(const WatchedSensor& magnetometer, const WatchedSensor& imu, double newest) {
  const Spans spans = spans_of(magnetometer, imu, newest);
  const Fit as_it_is = fit_of(spans);
  return as_it_is.valid && as_it_is.residual < kClearlyBetter * left_with(spans, turned_by(std::numbers::pi));
}

std::optional<Iron> iron_of(const WatchedSensor& magnetometer, const WatchedSensor& imu, double newest) {
  const Fit fit = fit_of(spans_of(magnetometer, imu, newest));
  if (!fit.valid) return std::nullopt;
  return Iron{fit.x.head<2>().norm(), std::max(fit.sigma(0), fit.sigma(1))};
}

}  // namespace waymark::host::diagnosis
