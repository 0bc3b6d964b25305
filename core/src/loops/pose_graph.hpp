// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "loops/planar.hpp"
#include "waymark/base/api.hpp"

namespace waymark::loops {

/// A place that was met again: the relation of two nodes of the path.
struct Loop {
  std::size_t from = 0;
  std::size_t to = 0;
  Relation relation;
  double path_chi_squared = 0.0;  ///< of the match against the path, when it was found
};

/// Poses along a path, related to their neighbours and by loops (F. Lu, E. Milios, 1997). The first one is fixed.
class WAYMARK_API PoseGraph {
 public:
  /// `steps[k]` relates node k to node k + 1. Both must outlive the object.
  PoseGraph(std::span<const Relation> steps, std::span<const Loop> loops) : steps_(steps), loops_(loops) {}

  std::size_t size() const { return steps_.size() + 1; }

  /// Least squares from `poses` on, one per node: Gauss-Newton on sparse equations. A loop that contradicts all else
  /// loses its weight (S. Geman, D. McClure, 1987), first only if it does so by far (H. Yang et al., RA-L 2020).
  void solve(std::vector<Eigen::Vector3d>& poses) const;
  /// Covariance of what is wrong with `nodes` at `poses`, a solution, as motions of the whole map (twist.hpp): three
  /// rows for each of them. Loops weigh as in the solution. Empty if the equations have none.
  Eigen::MatrixXd covariance(std::span<const Eigen::Vector3d> poses, std::span<const std::size_t> nodes) const;
  /// Squared Mahalanobis distance of a loop.
  static double chi_squared(const Loop& loop, std::span<const Eigen::Vector3d> poses);
  /// The way of least uncertainty from `node` to every other one, by steps and loops (E. Olson, 2008).
  std::vector<Relation> relations_from(std::size_t node) const;

 private:
  std::span<const Relation> steps_;
  std::span<const Loop> loops_;
};

/// The largest set of loops that agree with one another pairwise (J. Mangelson et al., ICRA 2018), found greedily from
/// each of them. `steps`: of the path. Indices, ascending.
WAYMARK_API std::vector<std::size_t> agreeing(std::span<const Loop> loops, std::span<const Relation> steps);

}  // namespace waymark::loops
