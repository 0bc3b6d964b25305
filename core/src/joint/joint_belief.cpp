// SPDX-License-Identifier: Apache-2.0
#include "joint/joint_belief.hpp"

#include <cstddef>

#include "waymark/math/gaussian.hpp"

namespace waymark::joint {

namespace {

/// So many points of a scan show which places it sees.
constexpr std::size_t kPoints = 90;

}  // namespace

void JointBelief::start(const Belief& prior, const Eigen::Matrix3d& frame) {
  Belief belief = prior;
  const auto& pose = process_.layout().pose_indices();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      belief.P(pose[static_cast<std::size_t>(i)], pose[static_cast<std::size_t>(j)]) += frame(i, j);
  }
  gaussian_.start(belief);
  anchors_.clear();
  landmarks_.clear();
}

void JointBelief::map(const MapEvidence& evidence, const Correspondences& correspondences) {
  if (evidence.is_prior) {
    // A loaded map is where it is.
    const gaussian::Eigen3 eigen = gaussian::eigen(evidence.information);
    gaussian_.relate(eigen.values.cwiseSqrt().asDiagonal() * eigen.vectors.transpose(), {});
    return;
  }
  if (!correspondences.landmarks.empty())
    landmarks_.observe(gaussian_, correspondences.landmarks, evidence.share, evidence.writes);
  if (correspondences.points_base.empty()) return;
  const Pose& T_map_base = gaussian_.belief().mean.T_map_base;
  const std::size_t step = 1 + (correspondences.points_base.size() - 1) / kPoints;
  points_.clear();
  for (std::size_t i = 0; i < correspondences.points_base.size(); i += step) {
    const Eigen::Vector2d& p = correspondences.points_base[i];
    points_.emplace_back((T_map_base * Eigen::Vector3d(p.x(), p.y(), 0.0)).head<2>());
  }
  anchors_.relate(gaussian_, evidence.information, points_);
  if (evidence.writes) anchors_.claim(gaussian_, points_);
}

std::optional<Eigen::Matrix2d> JointBelief::landmark_covariance(
    const Eigen::Vector2d& p_map, const NavState& mean,
    const std::optional<estimation::Georeference>& georeference) const {
  const auto node = landmarks_.node_at(p_map);
  if (!node) return std::nullopt;
  const Eigen::Matrix2d P = gaussian_.node_covariance(*node);
  if (!georeference) return P;
  return georeference->point_covariance(gaussian_.belief(), mean, p_map, P, gaussian_.cross_covariance(*node));
}

template <class Archive>
void JointBelief::serialize(Archive& archive) {
  archive.section("joint_belief", 1);
  archive(gaussian_);
  anchors_.serialize(archive, gaussian_);
  landmarks_.serialize(archive, gaussian_);
}
template void JointBelief::serialize(OutArchive& archive);
template void JointBelief::serialize(InArchive& archive);

}  // namespace waymark::joint
