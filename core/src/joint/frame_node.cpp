// SPDX-License-Identifier: Apache-2.0
#include "joint/frame_node.hpp"

#include <array>

#include "joint/white_match.hpp"
#include "waymark/base/error.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::joint {

namespace {

/// Height and tilt among the error states of spatial motion.
constexpr std::array<int, 3> kUpright{2, 3, 4};

/// Height and tilt of what lies at (x, y), if the map's frame is lifted and tilted.
Eigen::Matrix3d at(const Eigen::Vector3d& p) {
  Eigen::Matrix3d J = Eigen::Matrix3d::Identity();
  J(0, 1) = p.y();
  J(0, 2) = -p.x();
  return J;
}

}  // namespace

void FrameNode::begin(JointGaussian& gaussian) {
  // The node and the pose are one: a little noise, so that their covariance has an inverse.
  constexpr double kLeast = 1e-10;
  const Eigen::Matrix3d at_origin = at(-gaussian.belief().mean.T_map_base.p);
  node_ = gaussian.add_node(at_origin, kLeast * Eigen::Matrix3d::Identity(), kUpright);
}

void FrameNode::relate(JointGaussian& gaussian, const SpatialMatch& match) const {
  const auto [information, gradient] = match.about.height_and_tilt();
  if (!information.allFinite() || !gradient.allFinite()) return;
  const Pose& pose = gaussian.belief().mean.T_map_base;
  const Eigen::Vector3d turn = so3::log(pose.q * match.prior.q.conjugate());
  Eigen::Vector3d d(pose.p.z() - match.prior.p.z(), turn.x(), turn.y());
  const Eigen::Matrix3d J = at(pose.p);
  if (node_) d -= J * gaussian.pending_correction(*node_);

  const WhiteMatch white = whiten(information, gradient);
  const Eigen::Vector3d nu = white.target - white.W * d;
  if (node_) {
    gaussian.relate(nu, white.W, {{*node_, -white.W * J}}, kUpright);
  } else {
    gaussian.relate(nu, white.W, {}, kUpright);
  }
}

template <class Archive>
void FrameNode::serialize(Archive& archive, const JointGaussian& gaussian) {
  archive(node_);
  if constexpr (Archive::kReads) {
    if (node_ && (!gaussian.has_node(*node_) || gaussian.node_covariance(*node_).rows() != 3))
      throw DataError("the checkpoint's map has no node for its height and tilt");
  }
}
template void FrameNode::serialize(OutArchive& archive, const JointGaussian& gaussian);
template void FrameNode::serialize(InArchive& archive, const JointGaussian& gaussian);

}  // namespace waymark::joint
