// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
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
  /// Squared Mahalanobis distance of a loop.
  static double chi_squared(const Loop& loop, std::span<const Eigen::Vector3d> poses);
  /// The way of least uncertainty from `node` to every other one, by steps and loops (E. Olson, 2008).
  std::vector<Relation> relations_from(std::size_t node) const;

 private:
  std::span<const Relation> steps_;
  std::span<const Loop> loops_;
};

/// The largest set of loops that agree with one another pairwise (J. Mangelson et al., ICRA 2018), found greedily from
/// each of them. `relate(a, b)` is the relation of two nodes by the path alone. Indices, ascending.
template <class Relate>
std::vector<std::size_t> agreeing(std::span<const Loop> loops, const Relate& relate) {
  constexpr double kAgreement = 11.3;  // 99 % of three degrees of freedom
  const std::size_t count = loops.size();
  std::vector<std::vector<bool>> agree(count, std::vector<bool>(count, false));
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t k = i + 1; k < count; ++k) {
      // From one old place, by its loop to the new ones and by the other loop back, to the other old place.
      const Relation around =
          compose(compose(loops[i].relation, relate(loops[i].to, loops[k].to)), inverse(loops[k].relation));
      const Relation direct = relate(loops[i].from, loops[k].from);
      Eigen::Vector3d off = around.z - direct.z;
      off.z() = so3::wrap(off.z());
      agree[i][k] = agree[k][i] = off.dot((around.P + direct.P).inverse() * off) < kAgreement;
    }
  }
  std::vector<std::size_t> best;
  for (std::size_t first = 0; first < count; ++first) {
    std::vector<std::size_t> set{first};
    for (std::size_t k = 0; k < count; ++k) {
      bool fits = k != first;
      for (const std::size_t member : set) fits = fits && agree[member][k];
      if (fits) set.push_back(k);
    }
    if (set.size() > best.size()) best = set;
  }
  std::ranges::sort(best);
  return best;
}

}  // namespace waymark::loops
