// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "joint/joint_gaussian.hpp"
#include "waymark/base/api.hpp"
#include "waymark/interface/map_module.hpp"

namespace waymark::joint {

/// Landmarks as nodes of the joint Gaussian: two states each, the errors of east and north.
class WAYMARK_API LandmarkNodes {
 public:
  /// Updates with the landmarks that were observed again, and adds those that were not, if the map `writes`. `share`:
  /// exponent of their likelihood.
  void observe(JointGaussian& gaussian, std::span<const Correspondences::Landmark> observed, double share, bool writes);
  /// The node of the landmark at `p_map`, if it has one.
  std::optional<JointGaussian::NodeId> node_at(const Eigen::Vector2d& p_map) const;
  void clear() { landmarks_.clear(); }

  template <class Archive>
  void serialize(Archive& archive, const JointGaussian& gaussian);

 private:
  static constexpr std::size_t kMost = 150;  // with more, every step would take longer

  struct LandmarkNode {
    JointGaussian::NodeId node = 0;
    Eigen::Vector2d linearized_at = Eigen::Vector2d::Zero();  // in the map: kept, so that Jacobians agree
    Eigen::Vector2d last = Eigen::Vector2d::Zero();           // where the map had it last
    std::uint64_t sightings = 0;
    std::uint64_t last_step = 0;
  };
  int find(const Eigen::Vector2d& p_map) const;
  void observe_again(JointGaussian& gaussian, LandmarkNode& landmark, const Correspondences::Landmark& observed,
                     double share);
  void add(JointGaussian& gaussian, const Correspondences::Landmark& observed, double share);
  void remove_least(JointGaussian& gaussian);

  std::vector<LandmarkNode> landmarks_;
  std::uint64_t step_ = 0;
  std::vector<std::size_t> new_;  // scratch: indices of the observed ones without a node
};

}  // namespace waymark::joint
