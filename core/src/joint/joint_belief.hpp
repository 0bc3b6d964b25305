// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "estimation/georeference.hpp"
#include "joint/anchors.hpp"
#include "joint/joint_gaussian.hpp"
#include "joint/landmark_nodes.hpp"
#include "waymark/base/api.hpp"
#include "waymark/host/filter_settings.hpp"
#include "waymark/interface/map_module.hpp"

namespace waymark::joint {

/// What one map contributes to a mapping step.
struct MapEvidence {
  Eigen::Matrix3d information;  ///< about (x, y, yaw), as the filter used it
  double share = 1.0;           ///< exponent of the likelihood
  bool writes = true;           ///< the observation was added to the map
  bool is_prior = false;        ///< the map was loaded: its places are not uncertain
};

/// The covariance that the filter reports where maps localise: of the joint Gaussian over the navigation state and the
/// places of the map. Particles forget at resampling how uncertain their common past was; this Gaussian does not
/// (docs/math/joint.md). Takes all that the particles take, at the mean of the best one.
class WAYMARK_API JointBelief {
 public:
  /// `process` must outlive the object.
  JointBelief(const estimation::ProcessModel& process, const JointSettings& settings)
      : process_(process), gaussian_(process.layout()), anchors_(settings) {}

  /// Begins with the navigation state alone. `frame`: covariance of (x, y, yaw) of the map's origin, where the
  /// particles take the start pose for it.
  void start(const Belief& prior, const Eigen::Matrix3d& frame);
  /// The pose begins anew; the map stays.
  void restart(const Belief& belief) { gaussian_.restart(belief); }

  /// Before all that follows: the best particle's mean, at the present stamp.
  void linearize_at(const NavState& mean) { gaussian_.relinearize(mean); }
  void predict(Time to, bool standing) { gaussian_.predict(process_, to, standing); }
  void update(const Linearization& model, const estimation::StateJacobian& H) { gaussian_.update(model, H); }
  /// One map's part of a mapping step, before its pose is sampled. `correspondences` by the best particle's map.
  void map(const MapEvidence& evidence, const Correspondences& correspondences);

  /// `change` makes velocity and rate uncorrelated with all else.
  template <class Change>
  void replace_twist(const Change& change) {
    gaussian_.replace_twist(change);
  }
  /// `change` adds variance to the navigation state.
  template <class Change>
  void add_noise(const Change& change) {
    gaussian_.add_noise(change);
  }

  /// Marginal of the navigation state, linearised at `mean`.
  Belief marginal(const NavState& mean) const { return gaussian_.belief_at(mean); }
  /// Marginal covariance of (east, north) of a landmark at `p_map`, with the map's place on the Earth, if it is a
  /// state. Nothing if it has no node.
  std::optional<Eigen::Matrix2d> landmark_covariance(const Eigen::Vector2d& p_map, const NavState& mean,
                                                     const std::optional<estimation::Georeference>& georeference) const;

  template <class Archive>
  void serialize(Archive& archive);

 private:
  const estimation::ProcessModel& process_;
  JointGaussian gaussian_;
  Anchors anchors_;
  LandmarkNodes landmarks_;
  std::vector<Eigen::Vector2d> points_;  // scratch: in the map
};

}  // namespace waymark::joint
