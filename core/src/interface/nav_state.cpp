// SPDX-License-Identifier: Apache-2.0
#include "waymark/interface/nav_state.hpp"

#include <fmt/format.h>

#include "waymark/base/error.hpp"

namespace waymark {

namespace {

/// Core error states that planar motion keeps: x, y, yaw, v_x, v_y, omega_z.
constexpr std::array<int, 6> kPlanarStates = {0, 1, 5, 6, 7, 11};

}  // namespace

StateLayout::StateLayout(Motion motion, std::vector<Owner> owners) : motion_(motion), owners_(std::move(owners)) {
  active_.fill(-1);
  if (motion == Motion::planar) {
    for (std::size_t i = 0; i < kPlanarStates.size(); ++i)
      active_[static_cast<std::size_t>(kPlanarStates[i])] = static_cast<int>(i);
    core_size_ = static_cast<int>(kPlanarStates.size());
  } else {
    for (int i = 0; i < kCoreStates; ++i) active_[static_cast<std::size_t>(i)] = i;
    core_size_ = kCoreStates;
  }
  pose_ = {active_[0], active_[1], active_[5]};
  size_ = core_size_;
  std::string sizes;
  for (const Owner& owner : owners_) {
    offsets_.push_back(size_ - core_size_);
    size_ += static_cast<int>(owner.block.size());
    for (const BlockState& state : owner.block) flat_.push_back(&state);
    if (!owner.block.empty())
      sizes += fmt::format("{}{}: {}", sizes.empty() ? "" : ", ", owner.name, owner.block.size());
  }
  if (block_size() > kMaxBlockStates) {
    throw ConfigError(fmt::format("the sensors' own state blocks need {} states, at most {} fit ({})", block_size(),
                                  kMaxBlockStates, sizes));
  }
}

void boxplus(NavState& state, const ErrorVector& delta, const StateLayout& layout) {
  if (layout.motion() == StateLayout::Motion::planar) {
    state.T_map_base.p.head<2>() += delta.head<2>();
    state.T_map_base.q =
        (Eigen::Quaterniond(std::cos(0.5 * delta[2]), 0.0, 0.0, std::sin(0.5 * delta[2])) * state.T_map_base.q)
            .normalized();
    state.v_base.head<2>() += delta.segment<2>(3);
    state.w_base.z() += delta[5];
  } else {
    state.T_map_base.p += delta.head<3>();
    state.T_map_base.q = (so3::exp(delta.segment<3>(3)) * state.T_map_base.q).normalized();
    state.v_base += delta.segment<3>(6);
    state.w_base += delta.segment<3>(9);
  }
  state.block += delta.tail(layout.block_size());
}

ErrorVector boxminus(const NavState& a, const NavState& b, const StateLayout& layout) {
  ErrorVector delta(layout.size());
  const Eigen::Vector3d theta = so3::log(a.T_map_base.q * b.T_map_base.q.conjugate());
  const Eigen::Vector3d p = a.T_map_base.p - b.T_map_base.p;
  const Eigen::Vector3d v = a.v_base - b.v_base;
  const Eigen::Vector3d w = a.w_base - b.w_base;
  if (layout.motion() == StateLayout::Motion::planar) {
    delta.head<6>() << p.x(), p.y(), theta.z(), v.x(), v.y(), w.z();
  } else {
    delta.head<kCoreStates>() << p, theta, v, w;
  }
  delta.tail(layout.block_size()) = a.block - b.block;
  return delta;
}

Eigen::Matrix3d pose_covariance(const Belief& belief, const StateLayout& layout) {
  Eigen::Matrix3d P;
  const auto& index = layout.pose_indices();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      P(i, j) = belief.P(index[static_cast<std::size_t>(i)], index[static_cast<std::size_t>(j)]);
  }
  return P;
}

}  // namespace waymark
