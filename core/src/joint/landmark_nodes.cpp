// SPDX-License-Identifier: Apache-2.0
#include "joint/landmark_nodes.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <tuple>

#include "joint/twist.hpp"
#include "waymark/base/error.hpp"

namespace waymark::joint {

namespace {

/// The same landmark lies a little elsewhere in another particle's map, and after a correction.
constexpr double kSame = 1.0;  // [m]
/// A landmark that was corrected by more is linearised where it is now.
constexpr double kMoved = 0.3;  // [m]

/// R_base_map and p_map − p_map_base of the pose.
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

int LandmarkNodes::find(const Eigen::Vector2d& p_map) const {
  int best = -1;
  double least = kSame * kSame;
  for (std::size_t i = 0; i < landmarks_.size(); ++i) {
    const double distance = (landmarks_[i].last - p_map).squaredNorm();
    if (distance >= least) continue;
    least = distance;
    best = static_cast<int>(i);
  }
  return best;
}

void LandmarkNodes::observe(JointGaussian& gaussian, std::span<const Correspondences::Landmark> observed, double share,
                            bool writes) {
  ++step_;
  new_.clear();
  for (std::size_t i = 0; i < observed.size(); ++i) {
    const int known = find(observed[i].p_map);
    if (known < 0) {
      new_.push_back(i);
    } else {
      observe_again(gaussian, landmarks_[static_cast<std::size_t>(known)], observed[i], share);
    }
  }
  if (!writes) return;
  for (const std::size_t i : new_) {
    if (find(observed[i].p_map) >= 0) continue;
    if (landmarks_.size() >= kMost) remove_least(gaussian);
    add(gaussian, observed[i], share);
  }
}

void LandmarkNodes::observe_again(JointGaussian& gaussian, LandmarkNode& landmark,
                                  const Correspondences::Landmark& observed, double share) {
  if ((observed.p_map - landmark.linearized_at).norm() > kMoved) landmark.linearized_at = observed.p_map;
  landmark.last = observed.p_map;
  landmark.last_step = step_;
  ++landmark.sightings;
  const Placed pose(gaussian.belief().mean);
  const Eigen::LLT<Eigen::Matrix2d> noise(observed.R / share);
  if (noise.info() != Eigen::Success) return;
  const Eigen::Matrix2d whitened = noise.matrixL().solve(pose.R_base_map);
  gaussian.relate(-whitened * pose.moves(landmark.linearized_at), {{landmark.node, whitened}});
}

void LandmarkNodes::add(JointGaussian& gaussian, const Correspondences::Landmark& observed, double share) {
  const Placed pose(gaussian.belief().mean);
  const Eigen::Matrix2d noise = pose.R_base_map.transpose() * (observed.R / share) * pose.R_base_map;
  const JointGaussian::NodeId node = gaussian.add_node(pose.moves(observed.p_map), noise);
  landmarks_.push_back({node, observed.p_map, observed.p_map, 1, step_});
}

std::optional<JointGaussian::NodeId> LandmarkNodes::node_at(const Eigen::Vector2d& p_map) const {
  const int index = find(p_map);
  if (index < 0) return std::nullopt;
  return landmarks_[static_cast<std::size_t>(index)].node;
}

/// One that was seen once, the oldest first; then the one that was not seen for the longest time.
void LandmarkNodes::remove_least(JointGaussian& gaussian) {
  const auto least = std::ranges::min_element(landmarks_, {}, [](const LandmarkNode& landmark) {
    return std::tuple(landmark.sightings > 1, landmark.last_step, landmark.node);
  });
  gaussian.remove_node(least->node);
  landmarks_.erase(least);
}

template <class Archive>
void LandmarkNodes::serialize(Archive& archive, const JointGaussian& gaussian) {
  archive.section("landmark_nodes", 1);
  archive.each(landmarks_, [](auto& each, LandmarkNode& landmark) {
    each(landmark.node, landmark.linearized_at, landmark.last, landmark.sightings, landmark.last_step);
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
