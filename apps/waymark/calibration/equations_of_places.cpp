// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Cholesky>

#include "apps/waymark/calibration/equation_builder.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::calibration {

void Equations::add_positions(const Positions& positions, std::size_t index, Builder& out) const {
  const int delay = column_of(positions.sensor, "delay_s");
  const std::array<int, 2> arm{column_of(positions.sensor, "base_p_antenna_m", 0),
                               column_of(positions.sensor, "base_p_antenna_m", 1)};
  Eigen::Vector2d lever = positions.lever;
  for (int i = 0; i < 2; ++i) {
    if (arm[static_cast<std::size_t>(i)] >= 0) lever(i) += out.x(arm[static_cast<std::size_t>(i)]);
  }
  const int level = position_levels_[index];
  const double factor = out.level(level);
  for (const Positions::Fix& fix : positions.fixes) {
    if (!is_within(fix.t)) continue;
    const PoseAt at = pose_at(out, fix.t, delay);
    const Eigen::Matrix2d R = rotation(at.yaw);
    const Eigen::Vector2d expected = at.p + R * lever;
    const Eigen::Vector2d by_yaw = kQuarterTurn * (R * lever);
    out.measurement();
    for (int axis = 0; axis < 2; ++axis) {
      Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
      gradient(axis) = 1.0;
      gradient.z() = by_yaw(axis);
      out.pose(at, gradient, delay);
      for (int i = 0; i < 2; ++i) out.entry(arm[static_cast<std::size_t>(i)], R(axis, i));
      double residual = expected(axis) - fix.p(axis);
      const Slow& offset = offsets_[index][static_cast<std::size_t>(axis)];
      if (offset.count > 0) {
        residual += out.slow_value(offset, fix.t);
        out.slow(offset, fix.t, 1.0);
      }
      out.row(fix.t, residual, factor * fix.sigma, {{level, -1}, {2.0, 0.0}});
    }
  }
}

void Equations::add_headings(const Headings& headings, std::size_t index, Builder& out) const {
  const int delay = column_of(headings.sensor, "delay_s");
  const int mounting = column_of(headings.sensor, "base_T_sensor.yaw_deg");
  const double turned = mounting < 0 ? 0.0 : kDegree * out.x(mounting);
  const int level = heading_levels_[index];
  for (const Headings::One& one : headings.headings) {
    if (!is_within(one.t)) continue;
    const PoseAt at = pose_at(out, one.t, delay);
    out.measurement();
    out.pose(at, Eigen::Vector3d::UnitZ(), delay);
    out.entry(mounting, kDegree);
    out.row(one.t, so3::wrap(at.yaw - one.yaw + turned), out.level(level) * one.sigma, {{level, -1}, {2.0, 0.0}});
  }
}

void Equations::add_scanner(const Scanner& scanner, std::size_t index, Builder& out) const {
  const int delay = column_of(scanner.sensor, "delay_s");
  const int mounting = column_of(scanner.sensor, "base_T_sensor.yaw_deg");
  const std::array<int, 2> place{column_of(scanner.sensor, "base_T_sensor.xyz_m", 0),
                                 column_of(scanner.sensor, "base_T_sensor.xyz_m", 1)};
  const double turned = mounting < 0 ? 0.0 : kDegree * out.x(mounting);
  Eigen::Vector2d lever = scanner.lever;
  for (int i = 0; i < 2; ++i) {
    if (place[static_cast<std::size_t>(i)] >= 0) lever(i) += out.x(place[static_cast<std::size_t>(i)]);
  }
  const int level = scanner_levels_[index];
  for (const Scanner::Motion& one : scanner.motions) {
    if (!is_within(one.from) || !is_within(one.to)) continue;
    const PoseAt first = pose_at(out, one.from, delay);
    const PoseAt last = pose_at(out, one.to, delay);
    // The motion of the scanner in the axes of the base at the first scan: hand-eye equations in the plane.
    const double turn = last.yaw - first.yaw;
    const Eigen::Matrix2d to_axes = rotation(-turned - first.yaw);
    const Eigen::Matrix2d arm = rotation(-turned) * (rotation(turn) - Eigen::Matrix2d::Identity());
    const Eigen::Vector2d shift = to_axes * (last.p - first.p) + arm * lever;
    Eigen::Vector3d residual;
    residual << shift - one.moved.head<2>(), so3::wrap(turn - one.moved.z());
    const Eigen::Vector2d by_turn = rotation(-turned + turn) * (kQuarterTurn * lever);
    Eigen::Matrix3d by_last = Eigen::Matrix3d::Zero();
    by_last.topLeftCorner<2, 2>() = to_axes;
    by_last.topRightCorner<2, 1>() = by_turn;
    by_last(2, 2) = 1.0;
    Eigen::Matrix3d by_first = -by_last;
    by_first.topRightCorner<2, 1>() = -by_turn - to_axes * (kQuarterTurn * (last.p - first.p));
    Eigen::Vector3d by_mounting = Eigen::Vector3d::Zero();
    by_mounting.head<2>() = -kDegree * (kQuarterTurn * shift);
    const Eigen::LLT<Eigen::Matrix3d> L(one.covariance);
    if (L.info() != Eigen::Success) continue;
    residual = L.matrixL().solve(residual);
    by_first = L.matrixL().solve(by_first);
    by_last = L.matrixL().solve(by_last);
    by_mounting = L.matrixL().solve(by_mounting);
    Eigen::Matrix<double, 3, 2> by_place = Eigen::Matrix<double, 3, 2>::Zero();
    by_place.topRows<2>() = arm;
    by_place = L.matrixL().solve(by_place);
    out.measurement();
    for (int r = 0; r < 3; ++r) {
      out.pose(first, by_first.row(r), delay);
      out.pose(last, by_last.row(r), delay);
      out.entry(mounting, by_mounting(r));
      for (int i = 0; i < 2; ++i) out.entry(place[static_cast<std::size_t>(i)], by_place(r, i));
      out.row(one.from, residual(r), out.level(level), {{level, -1}, {2.0, 0.0}});
    }
  }
}

}  // namespace waymark::calibration
