// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "matching.hpp"

/// Ways to choose among the pairs of detections and landmarks in `association.pairs`, all of them within the gate and
/// likelier than a new landmark. Each fills `association.match` and the marks `taken`.
namespace waymark {

/// The most likely pair first (4.8).
void match_greedily(FeatureAssociation& association);

/// The greatest sum of log likelihoods, with `log_p0` for every detection without a landmark. Detections that compete
/// for no common landmark, directly or through others, are solved apart.
void match_optimally(double log_p0, FeatureAssociation& association);

/// Joint compatibility (J. Neira, J. D. Tardós, IEEE T-RA 17(6), 2001): pairs share the pose's error, so a set of them
/// must pass the χ² gate of its joint innovation. Branch and bound finds the set of most pairs, among those the
/// likeliest; after `joint_max_nodes` nodes the best one so far is taken. The joint distance is the sum of the
/// innovations' distances while the pose is refined by one pair after the other, linearised at `pose` with prior `P`.
template <int D>
void match_jointly(const FeatureMapSettings& settings, double log_p0, const Eigen::Vector3d& pose,
                   const Eigen::Matrix3d& P, const FeatureObservation& observation, FeatureAssociation& association);

}  // namespace waymark
