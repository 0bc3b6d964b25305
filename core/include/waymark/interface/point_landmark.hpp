// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "waymark/base/api.hpp"
#include "waymark/interface/map_view.hpp"
#include "waymark/interface/particle_map.hpp"

namespace waymark {

/// An observation that is one point, the same for all particles.
struct PointObservation : Observation {
  explicit PointObservation(const Eigen::Vector3d& p) : p_base(p) {}
  Eigen::Vector3d p_base;  ///< in the base frame [m]
};

/// A landmark of one particle's map: a place in the plane, as a Gaussian. What a module of your own needs of FastSLAM
/// for landmarks (M. Montemerlo, S. Thrun, FastSLAM, 2007) once it has decided which landmark it sees.
struct WAYMARK_API PointLandmark {
  Eigen::Vector2d p_map = Eigen::Vector2d::Zero();  ///< mean, east and north [m]
  Eigen::Matrix2d P = Eigen::Matrix2d::Zero();      ///< covariance [m²], given the particle's path
  std::int32_t sightings = 0;                       ///< 0: never seen, then nothing else of it counts

  /// Adds to `out` what seeing it at `p_base` (in the base frame, noise `R` [m²]) says of the pose: information,
  /// gradient and evidence. If `out` has some already, of other landmarks, the evidence is given these. A landmark that
  /// was never seen adds nothing.
  void match(const PoseGaussian& prior, const Eigen::Vector3d& p_base, const Eigen::Matrix2d& R, Refinement& out) const;

  /// Fuses a sighting into the place; the covariance that sampling left to the pose counts as noise.
  void fuse(const PoseGaussian& pose, const Eigen::Vector3d& p_base, const Eigen::Matrix2d& R);

  /// The same two for an observation that is a `PointObservation`.
  void match(const PoseGaussian& prior, const Observation& seen, const Eigen::Matrix2d& R, Refinement& out) const {
    match(prior, static_cast<const PointObservation&>(seen).p_base, R, out);
  }
  void fuse(const PoseGaussian& pose, const Observation& seen, const Eigen::Matrix2d& R) {
    fuse(pose, static_cast<const PointObservation&>(seen).p_base, R);
  }

  /// For reports, as confirmed and without a radius.
  LandmarkView view() const;
  /// Adds it to a map's description, if it was seen.
  void describe(MapDescription& out) const;

  template <class Archive>
  void serialize(Archive& archive) {
    archive(sightings, p_map, P);
  }
};

}  // namespace waymark
