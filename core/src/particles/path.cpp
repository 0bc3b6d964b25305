// SPDX-License-Identifier: Apache-2.0
#include "particles/path.hpp"

namespace waymark::particles {

namespace {

/// Amount of motion between two poses [m]; a rotation counts as the path of a point half a metre away.
double motion(const Pose& a, const Pose& b) {
  constexpr double kArm = 0.5;
  return (b.p - a.p).norm() + kArm * so3::log(b.q * a.q.conjugate()).norm();
}

}  // namespace

void Path::append(Time stamp, const Pose& T_map_base) {
  if (stay_.replaces_last(stamp, T_map_base)) drop_last();
  poses_.append({stamp, T_map_base});
}

void Path::append_tentative(Time stamp, const Pose& T_map_base) {
  if (stay_.replaces_last(stamp, T_map_base)) drop_last();
  tentative_.push_back({stamp, T_map_base});
}

void Path::drop_last() {
  if (tentative_.empty()) {
    poses_.drop_last();
  } else {
    tentative_.pop_back();
  }
}

void Path::distribute_correction(const Pose& predicted, const Pose& found) {
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

void Path::thin(std::span<Path* const> paths, std::size_t count) {
  std::vector<Lineage<StampedPose>*> lineages;
  lineages.reserve(paths.size());
  for (Path* path : paths) {
    std::size_t place = path->poses_.size();
    std::erase_if(path->tentative_, [&place, count](const StampedPose&) {
      const bool goes = place < count && place % 2 != 0;
      ++place;
      return goes;
    });
    lineages.push_back(&path->poses_);
  }
  Lineage<StampedPose>::thin(lineages, count);
}

void Path::replace(std::span<const StampedPose> poses) {
  poses_ = {};
  tentative_.clear();
  for (const StampedPose& pose : poses) poses_.append(pose);
}

std::vector<StampedPose> Path::poses() const { return poses_since({}); }

std::vector<StampedPose> Path::poses_since(const Path& known) const {
  std::vector<StampedPose> part = poses_.items_since(known.poses_);
  part.insert(part.end(), tentative_.begin(), tentative_.end());
  return part;
}

}  // namespace waymark::particles
