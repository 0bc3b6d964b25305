// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "loops/planar.hpp"
#include "loops/score_raster.hpp"
#include "waymark/base/api.hpp"

namespace waymark::loops {

/// Where to search for a match, around a prior.
struct SearchRange {
  double distance;  ///< half width [m]
  double angle;     ///< half width [rad]
};

/// A match of two windows.
struct WindowMatch {
  Relation relation;  ///< of the second window's frame to the first one's
  double score;       ///< mean likelihood of the second one's points, 0 … 1
};

/// Result of a search.
struct WindowSearch {
  std::optional<WindowMatch> match;  ///< if there is one that no other place of the range rivals
  bool is_ambiguous = false;         ///< too few points, or places that look the same: it says nothing
};

/// How large a window may be, and how finely it is searched.
struct MatcherSettings {
  double reach = 30.0;       ///< points of the window farther from its middle are left out [m]
  double turn_step = 0.01;   ///< of the headings that are tried [rad]
  std::size_t points = 350;  ///< that are searched, about so many at most
};

/// Finds how one window of scans lies in another: branch and bound over all places of a range (W. Hess et al., ICRA
/// 2016), then the moments of the likelihood around the best one. Holds its storage; not thread-safe.
class WAYMARK_API WindowMatcher {
 public:
  explicit WindowMatcher(const MatcherSettings& settings = {})
      : settings_(settings), coarse_(settings.reach), fine_(settings.reach) {}

  /// The window in which others are searched. Its points lie in its own frame [m].
  void draw(std::span<const Eigen::Vector2f> points);

  /// Searches `points`, of which too few match nowhere.
  WindowSearch match(std::span<const Eigen::Vector2f> points, const Eigen::Vector3d& prior, const SearchRange& range);

  /// Mean likelihood of points at a pose, 0 … 1; with as narrow a σ as a match is refined with.
  double score(std::span<const Eigen::Vector2f> points, const Eigen::Vector3d& at) const;

 private:
  struct Place {
    int turn;
    int x;  ///< [cells] from the prior
    int y;
    int level;
    int sum;
  };
  struct ScoredShift {
    Eigen::Vector3d shift;  // [m, m, rad]
    double score;           // 0 … 1
  };

  /// The best place with a sum above `least` that `is_allowed`; turn < 0: none.
  template <class IsAllowed>
  Place search(int least, const IsAllowed& is_allowed) const;
  template <class IsAllowed>
  void descend(const Place& place, Place& best, const IsAllowed& is_allowed) const;
  int sum(const Place& place) const;
  void turn_points(const Eigen::Vector3d& prior, const SearchRange& range);
  template <int kShifts, int kParts>
  void score_around(const Eigen::Vector3d& at, double turn, std::vector<ScoredShift>& scores) const;
  static double moments(std::span<const ScoredShift> scores, Eigen::Vector3d& mean, Eigen::Matrix3d& P);
  WindowMatch refine(const Eigen::Vector3d& around, double weak_sigma) const;

  MatcherSettings settings_;
  ScoreRaster coarse_;
  ScoreRaster fine_;
  std::vector<Eigen::Vector2f> points_;               // of the match, thinned
  std::vector<std::vector<Eigen::Vector2i>> turned_;  // cells of the points, by turn
  int reach_ = 0;                                     // half width of the range [cells]
};

}  // namespace waymark::loops
