// SPDX-License-Identifier: Apache-2.0
#include "particles/path.hpp"

namespace waymark::particles {

namespace {

/// Amount of motion between two poses [m]; a rotation counts as the path of a point half a metre away.
double motion(const Pose& a, const Pose& b) {
  constexpr double kArm = 0.5;
  return (b.p - a.p).norm() + kArm * so3::log(b.q * a.q.conjugate()).norm();
}

void save_pose(const StampedPose& pose, OutArchive& to) {
  to.value(pose.stamp);
  to.value(pose.T_map_base.p);
  to.value(Eigen::Vector4d(pose.T_map_base.q.coeffs()));
}

void load_pose(StampedPose& pose, InArchive& from) {
  Eigen::Vector4d q;
  from.value(pose.stamp);
  from.value(pose.T_map_base.p);
  from.value(q);
  pose.T_map_base.q = Eigen::Quaterniond(q);
}

}  // namespace

void Path::settle(const Pose& predicted, const Pose& found) {
  if (tentative_.empty()) return;
  // The motion to the first of them begins at the pose before, if there is one.
  const StampedPose* last = poses_.last();
  Pose from = last != nullptr ? last->T_map_base : tentative_.front().T_map_base;
  double whole = 0.0;
  for (const StampedPose& pose : tentative_) {
    whole += motion(from, pose.T_map_base);
    from = pose.T_map_base;
  }
  whole += motion(from, predicted);
  const Pose correction = found * predicted.inverse();
  from = last != nullptr ? last->T_map_base : tentative_.front().T_map_base;
  double part = 0.0;
  for (StampedPose pose : tentative_) {
    part += motion(from, pose.T_map_base);
    from = pose.T_map_base;
    const double share = whole > 0.0 ? part / whole : 0.0;
    const Pose moved = correction * pose.T_map_base;
    pose.T_map_base.p += share * (moved.p - pose.T_map_base.p);
    pose.T_map_base.q = pose.T_map_base.q.slerp(share, moved.q).normalized();
    poses_.append(pose);
  }
  tentative_.clear();
}

std::vector<StampedPose> Path::poses() const {
  std::vector<StampedPose> all = poses_.items();
  all.insert(all.end(), tentative_.begin(), tentative_.end());
  return all;
}

void Path::save(OutArchive& out) const {
  out.section("path", 2);
  poses_.save(out, save_pose);
  out.value(static_cast<std::uint64_t>(tentative_.size()));
  for (const StampedPose& pose : tentative_) save_pose(pose, out);
}

void Path::load(InArchive& in) {
  const std::uint32_t version = in.section("path", 2);
  poses_.load(in, load_pose);
  tentative_.clear();
  if (version < 2) return;
  std::uint64_t count = 0;
  in.value(count);
  for (std::uint64_t i = 0; i < count; ++i) {
    StampedPose pose{};
    load_pose(pose, in);
    tentative_.push_back(pose);
  }
}

}  // namespace waymark::particles
