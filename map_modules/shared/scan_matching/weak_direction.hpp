// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "map_modules/shared/scan_matching/descent.hpp"

namespace waymark::scan_matching {

/// The direction (x, y) that a scan constrains least, and how far it does, 0 … 1.
struct WeakDirection {
  double share = 1.0;
  Eigen::Vector2d direction = Eigen::Vector2d::Zero();
};

/// A wall is rough, since its cells were hit by chance: so along a corridor, too, every match has a best place and a
/// curvature about it, a fourth of that across, and they mean nothing. But they end within a cell. Moved along by
/// `shift` [m], the width of the wide field, the scan fits that as well as before, if nothing is there; beside an end
/// wall or a door it does not. Of both sides the better one counts: beyond the map's end nothing fits, which is no
/// reason to stay. `at` is the base (x, y, yaw).
WeakDirection find_weak_direction(const MatchTarget& target, const LikelihoodTable& wide, const Eigen::Vector3d& at,
                                  const Eigen::Matrix3d& information, double shift);

/// Keeps of the scan's information along `weak` only its share, and finds the maximum a posteriori with the prior
/// again.
Optimum without_weak_direction(const Optimum& optimum, const WeakDirection& weak, const MatchTarget& target,
                               const MatchPrior& prior, const LikelihoodTable& narrow);

}  // namespace waymark::scan_matching
