// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "ring.hpp"

namespace waymark::range_beacons {

/// The Gaussian over the scale of all ranges and the places of the beacons whose rings have become one place, with
/// their correlations: a scale that one beacon shows holds for the others.
class Survey {
 public:
  Survey() = default;
  Survey(double scale, double scale_sigma)
      : mean_(Eigen::VectorXd::Constant(1, scale)), P_(Eigen::MatrixXd::Constant(1, 1, scale_sigma * scale_sigma)) {}

  int size() const { return static_cast<int>(mean_.size() - 1) / 2; }
  double scale() const { return mean_[0]; }
  double scale_variance() const { return P_(0, 0); }

  /// Adds the beacon of a ring and returns its index. What the ring learnt of the scale beyond what it began with is
  /// new information, for the other beacons, too.
  int add(const Ring& ring);
  /// Place of a beacon and the scale.
  Place marginal(int index) const;
  /// Kalman update by a range to beacon `index`. `pose_variance`: what the uncertainty of the pose adds [m²].
  void update(int index, double range, double sigma, const Eigen::Vector2d& p_map_antenna, double pose_variance);

  template <class Archive>
  void serialize(Archive& archive) {
    archive.section("survey", 1);
    archive(mean_, P_);
    if constexpr (Archive::kReads) check_sizes();
  }

 private:
  void check_sizes() const;

  Eigen::VectorXd mean_;  // scale, then east and north of one beacon after the other
  Eigen::MatrixXd P_;
};

}  // namespace waymark::range_beacons
