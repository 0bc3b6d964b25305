// SPDX-License-Identifier: Apache-2.0
#include "estimation/georeference.hpp"

#include <cassert>

#include "waymark/math/so3.hpp"

namespace waymark::estimation {

StateBlock Georeference::block(StateLayout::Motion motion, const GeoreferenceSettings& settings) {
  StateBlock block;
  const auto add = [&](const char* name, double walk) {
    BlockState state;
    state.name = name;
    state.walk_per_sqrt_m = walk;
    block.push_back(state);
  };
  add("map_east_m", settings.position_walk_per_sqrt_m);
  add("map_north_m", settings.position_walk_per_sqrt_m);
  if (motion == StateLayout::Motion::spatial) add("map_up_m", settings.position_walk_per_sqrt_m);
  add("map_yaw_rad", settings.yaw_walk_per_sqrt_m);
  return block;
}

Georeference::Georeference(const StateLayout& layout, int owner)
    : layout_(layout),
      offset_(layout.block_offset(owner)),
      first_(layout.core_size() + offset_),
      has_height_(layout.motion() == StateLayout::Motion::spatial),
      yaw_(has_height_ ? 3 : 2) {
  assert(static_cast<int>(layout.owners()[static_cast<std::size_t>(owner)].block.size()) == yaw_ + 1);
}

Pose Georeference::T_enu_map(const NavState& state) const {
  const auto& b = state.block;
  Pose pose = Pose::planar(b[offset_], b[offset_ + 1], b[offset_ + yaw_]);
  if (has_height_) pose.p.z() = b[offset_ + 2];
  return pose;
}

NavState Georeference::in_enu(const NavState& state) const {
  NavState enu = state;
  enu.T_map_base = T_enu_map(state) * state.T_map_base;
  return enu;
}

/// δp_enu = R δp + δt + (ẑ × R p) δψ, δθ_enu = R δθ + ẑ δψ.
void Georeference::scatter(const NavState& state, int block_offset, const Linearization& model,
                           StateJacobian& out) const {
  using Jacobian = Linearization::Jacobian3;
  const Eigen::Matrix3d R_enu_map = T_enu_map(state).q.toRotationMatrix();
  const Eigen::Vector3d lever_enu = R_enu_map * state.T_map_base.p;  // from the map's origin to the base
  const Jacobian zero = Jacobian::Zero(model.rows(), 3);
  const Jacobian& Hp = model.uses(Linearization::kPosition) ? model.get(Linearization::kPosition) : zero;
  const Jacobian& Ha = model.uses(Linearization::kAttitude) ? model.get(Linearization::kAttitude) : zero;
  const Jacobian p = Hp * R_enu_map;
  const Jacobian a = Ha * R_enu_map;
  for (int axis = 0; axis < 3; ++axis) {
    out.add(layout_.active(axis), p.col(axis));
    out.add(layout_.active(3 + axis), a.col(axis));
  }
  const int shifts = has_height_ ? 3 : 2;
  for (int axis = 0; axis < shifts; ++axis) out.add(first_ + axis, Hp.col(axis));
  out.add(first_ + shifts, (Hp * Eigen::Vector3d(-lever_enu.y(), lever_enu.x(), 0.0) + Ha.col(2)).eval());
  estimation::scatter(layout_, block_offset, model, out, Linearization::kVelocity);
}

void Georeference::to_enu(Belief& belief) const {
  const Pose T = T_enu_map(belief.mean);
  const Eigen::Matrix3d R_enu_map = T.q.toRotationMatrix();
  const Eigen::Vector3d lever_enu = R_enu_map * belief.mean.T_map_base.p;  // from the map's origin to the base
  const int n = layout_.size();
  const int yaw = first_ + yaw_;
  ErrorMatrix& P = belief.P;
  // J differs from the identity in the pose's rows only: δp' = R δp + δt + (ẑ × R p) δψ, δθ' = R δθ + ẑ δψ. First the
  // rows of J P, then its columns by the same rule.
  const auto compose = [&](auto&& get, auto&& set) {
    using Line = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxErrorStates, 1>;
    std::array<Line, 6> before;
    for (int i = 0; i < 6; ++i) {
      if (layout_.active(i) >= 0) before[static_cast<std::size_t>(i)] = get(layout_.active(i));
    }
    const Line turned = get(yaw);
    for (int part = 0; part < 2; ++part) {
      for (int axis = 0; axis < 3; ++axis) {
        const int row = layout_.active(3 * part + axis);
        if (row < 0) continue;
        Line line = Line::Zero(n);
        for (int k = 0; k < 3; ++k) {
          const int from = 3 * part + k;
          if (layout_.active(from) >= 0) line += R_enu_map(axis, k) * before[static_cast<std::size_t>(from)];
        }
        if (part == 0) {
          const Eigen::Vector3d moved(-lever_enu.y(), lever_enu.x(), 0.0);
          line += moved[axis] * turned;
          if (axis < 2 || has_height_) line += get(first_ + axis);
        } else if (axis == 2) {
          line += turned;
        }
        set(row, line);
      }
    }
  };
  compose([&](int i) { return P.row(i).transpose(); }, [&](int i, const auto& line) { P.row(i) = line.transpose(); });
  compose([&](int i) { return P.col(i); }, [&](int i, const auto& line) { P.col(i) = line; });
  belief.mean.T_map_base = T * belief.mean.T_map_base;
}

/// δp = Rᵀ (δp_enu − δt − (ẑ × R p) δψ), δθ = Rᵀ (δθ_enu − ẑ δψ). Not on the path of a measurement, so J is dense.
void Georeference::to_map(Belief& belief) const {
  const Pose T = T_enu_map(belief.mean);
  const Eigen::Matrix3d R_map_enu = T.q.toRotationMatrix().transpose();
  const Eigen::Vector3d lever_enu = belief.mean.T_map_base.p - T.p;  // from the map's origin to the base
  const Eigen::Vector3d lever_map = R_map_enu * lever_enu;
  ErrorMatrix J = ErrorMatrix::Identity(layout_.size(), layout_.size());
  for (int axis = 0; axis < 3; ++axis) {
    const int p = layout_.active(axis);
    const int a = layout_.active(3 + axis);
    for (int k = 0; k < 3; ++k) {
      if (p >= 0 && layout_.active(k) >= 0) J(p, layout_.active(k)) = R_map_enu(axis, k);
      if (a >= 0 && layout_.active(3 + k) >= 0) J(a, layout_.active(3 + k)) = R_map_enu(axis, k);
      if (p >= 0 && (k < 2 || has_height_)) J(p, first_ + k) = -R_map_enu(axis, k);
    }
    if (p >= 0) J(p, first_ + yaw_) = axis == 0 ? lever_map.y() : (axis == 1 ? -lever_map.x() : 0.0);
    if (a >= 0 && axis == 2) J(a, first_ + yaw_) = -1.0;
  }
  belief.P = (J * belief.P * J.transpose()).eval();
  belief.P = (0.5 * (belief.P + belief.P.transpose())).eval();
  belief.mean.T_map_base = T.inverse() * belief.mean.T_map_base;
}

void Georeference::take_over_start(Belief& prior) const {
  const auto& pose = layout_.pose_indices();
  const Pose start = prior.mean.T_map_base;
  const double yaw = start.yaw();
  prior.mean.block[offset_] = start.p.x();
  prior.mean.block[offset_ + 1] = start.p.y();
  if (has_height_) prior.mean.block[offset_ + 2] = start.p.z();
  prior.mean.block[offset_ + yaw_] = yaw;
  prior.mean.T_map_base = T_enu_map(prior.mean).inverse() * start;

  const Eigen::Matrix3d P = pose_covariance(prior, layout_);
  for (std::size_t i = 0; i < 3; ++i) {
    prior.P.row(pose[i]).setZero();
    prior.P.col(pose[i]).setZero();
  }
  prior.P(planar_states(), planar_states()) = P;
}

void Georeference::inflate(Belief& belief, double position_variance, double yaw_variance) const {
  belief.P(first_, first_) += position_variance;
  belief.P(first_ + 1, first_ + 1) += position_variance;
  belief.P(first_ + yaw_, first_ + yaw_) += yaw_variance;
}

Eigen::Matrix2d Georeference::point_covariance(const Belief& belief, const Eigen::Vector2d& p_map) const {
  const Pose T = T_enu_map(belief.mean);
  const Eigen::Vector2d lever = (T.q * Eigen::Vector3d(p_map.x(), p_map.y(), 0.0)).head<2>();
  Eigen::Matrix<double, 2, 3> J;
  J << 1.0, 0.0, -lever.y(), 0.0, 1.0, lever.x();
  const Eigen::Matrix3d P = belief.P(planar_states(), planar_states());
  return J * P * J.transpose();
}

Eigen::Matrix2d Georeference::point_covariance(
    const Belief& belief, const NavState& state, const Eigen::Vector2d& p_map, const Eigen::Matrix2d& P,
    const Eigen::Ref<const Eigen::Matrix<double, 2, Eigen::Dynamic>>& cross) const {
  const Eigen::Matrix2d R = T_enu_map(state).q.toRotationMatrix().topLeftCorner<2, 2>();
  const Eigen::Vector2d lever = R * p_map;
  Eigen::Matrix<double, 2, 3> J;
  J << 1.0, 0.0, -lever.y(), 0.0, 1.0, lever.x();
  const Eigen::Matrix3d P_place = belief.P(planar_states(), planar_states());
  const Eigen::Matrix2d mixed = R * cross(Eigen::all, planar_states()) * J.transpose();
  return J * P_place * J.transpose() + R * P * R.transpose() + mixed + mixed.transpose();
}

}  // namespace waymark::estimation
