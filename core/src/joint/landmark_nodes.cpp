// SPDX-License-Identifier: Apache-2.0
#include "joint/landmark_nodes.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>

#include "loops/twist.hpp"
#include "waymark/base/error.hpp"

namespace waymark::joint {

namespace {

/// A landmark within this of where one was seen may be that one.
constexpr double kSame = 0.5;  // [m]
/// A landmark that was corrected by more is linearised where it is now.
constexpr double kMoved = 0.3;  // [m]
/// χ², 99.9 % of two degrees of freedom: particles that are resampled away had other associations, and one that is
/// wrong cannot be taken back here.
constexpr double kGate = 13.8;

/// The pose in the plane.
struct Placed {
  explicit Placed(const NavState& nav)
      : p(nav.T_map_base.p.head<2>()), R_base_map(Eigen::Rotation2Dd(-nav.T_map_base.yaw()).toRotationMatrix()) {}
  Eigen::Vector2d p;
  Eigen::Matrix2d R_base_map;
  /// δp of a point at `p_map` by (δx, δy, δyaw) of the pose.
  Eigen::Matrix<double, 2, 3> moves(const Eigen::Vector2d& p_map) const {
    return loops::error_of_twist(p_map - p).topRows<2>();
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
  gaussian.relate_within(kGate, nu, -whitened * pose.moves(landmark.linearized_at), {{landmark.node, whitened}});
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

void LandmarkNodes::make_room(JointGaussian& gaussian, std::size_t most) {
  while (landmarks_.size() > most) {
    const std::size_t doubtful = find_doubtful();
    const std::size_t removed = doubtful < landmarks_.size() ? doubtful : find_replaceable();
    if (removed == landmarks_.size()) return;
    gaussian.remove_node(landmarks_[removed].node);
    landmarks_.erase(landmarks_.begin() + static_cast<std::ptrdiff_t>(removed));
  }
}

std::size_t LandmarkNodes::find_doubtful() const {
  std::size_t oldest = landmarks_.size();
  for (std::size_t i = 0; i < landmarks_.size(); ++i) {
    if (landmarks_[i].sightings > 1 || landmarks_[i].last_step == step_) continue;
    if (oldest == landmarks_.size() || landmarks_[i].last_step < landmarks_[oldest].last_step) oldest = i;
  }
  return oldest;
}

double LandmarkNodes::room_about(std::size_t landmark) const {
  double nearest = std::numeric_limits<double>::infinity();
  double second = nearest;
  for (std::size_t k = 0; k < landmarks_.size(); ++k) {
    if (k == landmark) continue;
    const double distance = (landmarks_[k].mean - landmarks_[landmark].mean).norm();
    second = std::min(second, std::max(nearest, distance));
    nearest = std::min(nearest, distance);
  }
  return nearest + second;
}

/// Every place keeps some, so that a return to it still closes the loop here, and where the robot is now all stay.
std::size_t LandmarkNodes::find_replaceable() {
  steps_.clear();
  for (const LandmarkNode& landmark : landmarks_) steps_.push_back(landmark.last_step);
  const auto middle = steps_.begin() + static_cast<std::ptrdiff_t>(steps_.size() / 2);
  std::ranges::nth_element(steps_, middle);
  std::size_t found = landmarks_.size();
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < landmarks_.size(); ++i) {
    if (landmarks_[i].last_step > *middle || landmarks_[i].last_step == step_) continue;
    const double room = room_about(i);
    if (room > least) continue;  // of equals the later one goes
    least = room;
    found = i;
  }
  return found;
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
