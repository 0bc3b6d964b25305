// SPDX-License-Identifier: Apache-2.0
#include "joint/landmark_nodes.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

#include "joint/twist.hpp"
#include "waymark/base/error.hpp"

namespace waymark::joint {

namespace {

/// A landmark within this of where one was seen may be that one.
constexpr double kSame = 0.5;  // [m]
/// A landmark that was corrected by more is linearised where it is now.
constexpr double kMoved = 0.3;  // [m]

/// The pose in the plane.
struct Placed {
  explicit Placed(const NavState& nav)
      : p(nav.T_map_base.p.head<2>()), R_base_map(Eigen::Rotation2Dd(-nav.T_map_base.yaw()).toRotationMatrix()) {}
  Eigen::Vector2d p;
  Eigen::Matrix2d R_base_map;
  /// δp of a point at `p_map` by (δx, δy, δyaw) of the pose.
  Eigen::Matrix<double, 2, 3> moves(const Eigen::Vector2d& p_map) const {
    return error_of_twist(p_map - p).topRows<2>();
  }
};

}  // namespace

/// Another particle's map may have the same landmark by another birth: then it is the nearest one to where it was seen.
LandmarkNodes::LandmarkNode* LandmarkNodes::find_or_adopt(const JointGaussian& gaussian,
                                                          const Correspondences::Landmark& observed) {
  const auto known = std::ranges::find(landmarks_, observed.birth, &LandmarkNode::birth);
  if (known != landmarks_.end()) return &*known;
  const Placed pose(gaussian.belief().mean);
  const Eigen::Vector2d p = pose.p + pose.R_base_map.transpose() * observed.p_base;
  LandmarkNode* nearest = nullptr;
  double least = kSame;
  for (LandmarkNode& landmark : landmarks_) {
    const double distance = (landmark.mean + gaussian.pending_correction(landmark.node) - p).norm();
    if (distance >= least || landmark.last_step == step_) continue;
    least = distance;
    nearest = &landmark;
  }
  if (nearest != nullptr) nearest->birth = observed.birth;
  return nearest;
}

void LandmarkNodes::observe(JointGaussian& gaussian, std::span<const Correspondences::Landmark> observed, double share,
                            bool writes) {
  ++step_;
  new_.clear();
  for (std::size_t i = 0; i < observed.size(); ++i) {
    LandmarkNode* known = observed[i].is_new ? nullptr : find_or_adopt(gaussian, observed[i]);
    if (known == nullptr) {
      new_.push_back(i);
    } else {
      observe_again(gaussian, *known, observed[i], share);
    }
  }
  if (!writes) return;
  for (const std::size_t i : new_) add(gaussian, observed[i], share);
}

void LandmarkNodes::observe_again(JointGaussian& gaussian, LandmarkNode& landmark,
                                  const Correspondences::Landmark& observed, double share) {
  landmark.mean += gaussian.take_correction(landmark.node);
  if ((landmark.mean - landmark.linearized_at).norm() > kMoved) landmark.linearized_at = landmark.mean;
  landmark.last_step = step_;
  ++landmark.sightings;
  const Placed pose(gaussian.belief().mean);
  const Eigen::LLT<Eigen::Matrix2d> noise(observed.R / share);
  if (noise.info() != Eigen::Success) return;
  const Eigen::Matrix2d whitened = noise.matrixL().solve(pose.R_base_map);
  const Eigen::Vector2d nu = noise.matrixL().solve(observed.p_base - pose.R_base_map * (landmark.mean - pose.p));
  gaussian.relate(nu, -whitened * pose.moves(landmark.linearized_at), {{landmark.node, whitened}});
}

void LandmarkNodes::add(JointGaussian& gaussian, const Correspondences::Landmark& observed, double share) {
  const Placed pose(gaussian.belief().mean);
  const Eigen::Matrix2d noise = pose.R_base_map.transpose() * (observed.R / share) * pose.R_base_map;
  const Eigen::Vector2d mean = pose.p + pose.R_base_map.transpose() * observed.p_base;
  const JointGaussian::NodeId node = gaussian.add_node(pose.moves(mean), noise);
  landmarks_.push_back({node, observed.birth, mean, mean, 1, step_});
}

std::optional<LandmarkNodes::Estimate> LandmarkNodes::find(std::uint64_t birth) const {
  const auto known = std::ranges::find(landmarks_, birth, &LandmarkNode::birth);
  if (birth == 0 || known == landmarks_.end()) return std::nullopt;
  return Estimate{known->mean, known->node};
}

bool LandmarkNodes::remove_doubtful(JointGaussian& gaussian) {
  auto oldest = landmarks_.end();
  for (auto landmark = landmarks_.begin(); landmark != landmarks_.end(); ++landmark) {
    if (landmark->sightings > 1 || landmark->last_step == step_) continue;
    if (oldest == landmarks_.end() || landmark->last_step < oldest->last_step) oldest = landmark;
  }
  if (oldest == landmarks_.end()) return false;
  gaussian.remove_node(oldest->node);
  landmarks_.erase(oldest);
  return true;
}

template <class Archive>
void LandmarkNodes::serialize(Archive& archive, const JointGaussian& gaussian) {
  archive.section("landmark_nodes", 1);
  archive.each(landmarks_, [](auto& each, LandmarkNode& landmark) {
    each(landmark.node, landmark.birth, landmark.mean, landmark.linearized_at, landmark.sightings, landmark.last_step);
  });
  archive(step_);
  if constexpr (Archive::kReads) {
    if (!std::ranges::all_of(landmarks_,
                             [&](const LandmarkNode& landmark) { return gaussian.has_node(landmark.node); }))
      throw DataError("the checkpoint has landmarks that do not fit its joint Gaussian");
  }
}
template void LandmarkNodes::serialize(OutArchive& archive, const JointGaussian& gaussian);
template void LandmarkNodes::serialize(InArchive& archive, const JointGaussian& gaussian);

}  // namespace waymark::joint
