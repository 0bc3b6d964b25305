// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "apps/waymark/evaluation/trajectory_io.hpp"
#include "waymark/interface/map_view.hpp"

namespace waymark::evaluation {

/// How often detections went into the right landmark. What a detection shows is the surveyed thing next to where the
/// *true* pose puts it; what a landmark stands for is what its first detection showed.
struct AssociationError {
  std::size_t correct = 0;  ///< into a landmark that stands for the same thing
  std::size_t wrong = 0;    ///< into a landmark that stands for another thing, or for none that is surveyed
  std::size_t known = 0;    ///< of a thing that had its landmark
  std::size_t found = 0;    ///< of these: into that landmark, not into a duplicate and not into a new one

  double precision() const;  ///< correct of all that went into a landmark; 1 if none did
  double recall() const;     ///< found of known; 1 if none was
};

/// Scores the sightings of one particle and its ancestors, in order of time. A thing's landmark is the oldest one that
/// stands for it and has `min_sightings` in all: what was dropped before it was confirmed is none. Sightings before or
/// after the truth are left out.
AssociationError score_associations(const std::vector<Sighting>& sightings, const Trajectory& truth,
                                    const std::vector<Landmark>& survey, double match_radius_m, int min_sightings);

}  // namespace waymark::evaluation
