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
#include "waymark/interface/particle_map.hpp"

namespace waymark::joint {

/// Landmarks as nodes of the joint Gaussian: two states each, the errors of east and north.
class WAYMARK_API LandmarkNodes {
 public:
  /// Updates with the landmarks that were observed again, and adds those that were not, if the map `writes`. `share`:
  /// exponent of their likelihood.
  void observe(JointGaussian& gaussian, std::span<const Correspondences::Landmark> observed, double share, bool writes);
  /// Mean of a landmark, and its node.
  struct Estimate {
    Eigen::Vector2d mean;
    JointGaussian::NodeId node;
  };
  /// The landmark of this birth; nothing if it has no node.
  std::optional<Estimate> find(std::uint64_t birth) const;
  std::size_t size() const { return landmarks_.size(); }
  /// Forgets landmarks until there are at most `most`, none of the last step: at first those that were seen only once,
  /// then of the half that was seen longest ago those that stand closest.
  void make_room(JointGaussian& gaussian, std::size_t most);
  void clear() { landmarks_.clear(); }

  template <class Archive>
  void serialize(Archive& archive, const JointGaussian& gaussian);

 private:
  struct LandmarkNode {
    JointGaussian::NodeId node = 0;
    std::uint64_t birth = 0;
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    Eigen::Vector2d linearized_at = Eigen::Vector2d::Zero();  // kept, so that Jacobians agree
    std::uint64_t sightings = 0;
    std::uint64_t last_step = 0;
  };
  LandmarkNode* find_or_adopt(const JointGaussian& gaussian, const Correspondences::Landmark& observed);
  void observe_again(JointGaussian& gaussian, LandmarkNode& landmark, const Correspondences::Landmark& observed,
                     double share);
  void add(JointGaussian& gaussian, const Correspondences::Landmark& observed, double share);
  /// Index of the landmark that was seen once, in an earlier step, and that the longest ago; `size()`: none.
  std::size_t find_doubtful() const;
  /// Index of the landmark of long ago that has the least room about it; `size()`: none.
  std::size_t find_replaceable();
  /// Distances to the two nearest others, summed [m]: with one alone an even row would vanish from its end.
  double room_about(std::size_t landmark) const;

  std::vector<LandmarkNode> landmarks_;
  std::uint64_t step_ = 0;
  std::vector<std::size_t> new_;      // scratch: indices of the observed ones without a node
  std::vector<std::uint64_t> steps_;  // scratch
};

}  // namespace waymark::joint
