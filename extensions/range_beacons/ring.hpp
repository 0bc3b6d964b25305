// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "settings.hpp"

namespace waymark::range_beacons {

/// Density of a range before it is used, and the Gaussian's parts of it.
struct PredictedRange {
  double nu = 0.0;                ///< z − k |p − b|, with the mean of its second-order term [m]
  double variance = 0.0;          ///< of that, without the pose's part [m²]
  double distance = 0.0;          ///< from the antenna to the place [m]
  Eigen::RowVector2d by_antenna;  ///< of the expected range, by the antenna's position [-]
};

/// One place where the beacon may stand: a Gaussian over its east and north [m] and the scale [-].
struct Place {
  double log_weight = 0.0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d P = Eigen::Matrix3d::Zero();

  PredictedRange predict(double range, double sigma, const Eigen::Vector2d& p_map_antenna) const;
  /// Kalman update. `pose_variance`: what the uncertainty of the pose adds to the range [m²].
  void update(double range, double sigma, const Eigen::Vector2d& p_map_antenna, double pose_variance);

  template <class Archive>
  void serialize(Archive& archive) {
    archive(log_weight, mean, P);
  }
};

/// Where a beacon stands as far as ranges alone say: a ring around the place of its first range, as a sum of Gaussians
/// (N. M. Kwok, G. Dissanayake, Q. P. Ha, "Bearing-only SLAM using a SPRT based Gaussian sum filter", ICRA 2005, for
/// bearings; here in range). Later ranges weigh its members; those without weight go, those that agree become one.
class Ring {
 public:
  Ring() = default;
  /// The ring of the first range, with the scale's Gaussian as it was then.
  Ring(double range, double sigma, const Antenna& antenna, const Eigen::Matrix3d& pose_P, double scale,
       double scale_variance);

  /// log p(range | all ranges before), over the places; `pose_P`: covariance of (x, y, yaw).
  double log_evidence(double range, double sigma, const Antenna& antenna, const Eigen::Matrix3d& pose_P) const;
  void update(double range, double sigma, const Antenna& antenna, const Eigen::Matrix3d& pose_P);

  const std::vector<Place>& places() const { return places_; }
  /// Mean and covariance of the whole mixture.
  Place collapsed() const;
  double first_scale() const { return first_scale_; }                    ///< the scale that it began with
  double first_scale_variance() const { return first_scale_variance_; }  ///< and its variance

  template <class Archive>
  void serialize(Archive& archive) {
    archive(places_, first_scale_, first_scale_variance_);
  }

 private:
  void normalise();
  void merge();

  std::vector<Place> places_;
  double first_scale_ = 1.0;
  double first_scale_variance_ = 0.0;
};

}  // namespace waymark::range_beacons
