// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "map_modules/feature_map/landmarks/landmark_store.hpp"
#include "map_modules/feature_map/landmarks/nearby_landmarks.hpp"
#include "waymark/interface/particle_map.hpp"
#include "waymark/math/assignment.hpp"

namespace waymark::feature_map {

/// Storage of the optimal assignment: kept from step to step, so that a warm step does not allocate.
struct AssignmentWorkspace {
  AssignmentSolver solver;
  std::vector<double> cost;
  std::vector<int> component;     ///< per detection: the smallest index of those it competes with
  std::vector<int> first_seeker;  ///< per nearby landmark: a detection that may be it, or -1
  std::vector<int> rows;          ///< detections of one component
  std::vector<int> columns;       ///< landmarks of one component
  std::vector<int> column_of;     ///< per nearby landmark: its column, or -1
};

/// Which landmark each detection is associated with, in one particle; with the scratch space that makes the next step
/// free of allocation.
class FeatureAssociation final : public Association {
 public:
  static constexpr std::int32_t kNew = -1;        ///< `chunk` of a detection that makes a new landmark
  static constexpr std::int32_t kAmbiguous = -2;  ///< neither associated nor new: it writes nothing

  std::vector<LandmarkRef> landmark_of;  ///< per detection; chunk kNew or kAmbiguous where there is none
  std::vector<LandmarkRef> missed;       ///< landmarks that should have been seen

  /// A detection and a nearby landmark that it may belong to.
  struct Pair {
    double log_likelihood;  ///< of place and signature
    int detection;
    int nearby;
  };
  std::vector<float> missed_log_odds;  ///< of those that are confirmed
  NearbyLandmarks nearby;
  std::vector<Pair> pairs;                 ///< all candidates
  double signature_distance_of_new = 0.0;  ///< D in p₀
  std::vector<std::size_t> undecided;      ///< detections for which another landmark is nearly as likely
  int associated = 0;                      ///< detections with a landmark
  int ambiguous = 0;                       ///< of those: another landmark, or none, was at least a tenth as likely
  AssignmentWorkspace workspace;
};

}  // namespace waymark::feature_map
