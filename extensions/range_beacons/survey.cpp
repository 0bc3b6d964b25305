// SPDX-License-Identifier: Apache-2.0
#include "survey.hpp"

#include <algorithm>

#include "waymark/base/error.hpp"

namespace waymark::range_beacons {

int Survey::add(const Ring& ring) {
  const Place place = ring.collapsed();
  const double before = ring.first_scale_variance();
  Eigen::Vector2d by_scale = Eigen::Vector2d::Zero();
  if (before > 0.0 && place.P(2, 2) > 0.0) {
    by_scale = place.P.topRightCorner<2, 1>() / place.P(2, 2);
    // The ratio of two Gaussians over the scale: what the ring has learnt, by what it began with.
    const double information = 1.0 / place.P(2, 2) - 1.0 / before;
    if (information > 0.0) {
      const double value = (place.mean[2] / place.P(2, 2) - ring.first_scale() / before) / information;
      const Eigen::VectorXd PHt = P_.col(0);
      const double S = P_(0, 0) + 1.0 / information;
      mean_ += PHt * ((value - mean_[0]) / S);
      P_ -= PHt * PHt.transpose() / S;
    }
  }
  const Eigen::Matrix2d given_scale = place.P.topLeftCorner<2, 2>() - by_scale * place.P.bottomLeftCorner<1, 2>();
  const Eigen::Index n = mean_.size();
  mean_.conservativeResize(n + 2);
  mean_.tail<2>() = place.mean.head<2>() + by_scale * (mean_[0] - place.mean[2]);
  P_.conservativeResize(n + 2, n + 2);
  P_.block(n, 0, 2, n) = by_scale * P_.row(0).head(n);
  P_.block(0, n, n, 2) = P_.block(n, 0, 2, n).transpose();
  P_.block<2, 2>(n, n) = 0.5 * (given_scale + given_scale.transpose()) + P_(0, 0) * by_scale * by_scale.transpose();
  return static_cast<int>(n - 1) / 2;
}

Place Survey::marginal(int index) const {
  const Eigen::Index first = 1 + 2 * index;
  Place place;
  place.mean << mean_.segment<2>(first), mean_[0];
  place.P.topLeftCorner<2, 2>() = P_.block<2, 2>(first, first);
  place.P.topRightCorner<2, 1>() = P_.block<2, 1>(first, 0);
  place.P.bottomLeftCorner<1, 2>() = P_.block<1, 2>(0, first);
  place.P(2, 2) = P_(0, 0);
  return place;
}

void Survey::update(int index, double range, double sigma, const Eigen::Vector2d& p_map_antenna, double pose_variance) {
  const Place place = marginal(index);
  const PredictedRange seen = place.predict(range, sigma, p_map_antenna);
  const Eigen::Index first = 1 + 2 * index;
  Eigen::VectorXd PHt = -P_.middleCols<2>(first) * seen.by_antenna.transpose();
  PHt += seen.distance * P_.col(0);
  const double S = seen.variance + pose_variance;
  mean_ += PHt * (seen.nu / S);
  P_ -= PHt * PHt.transpose() / S;
}

void Survey::check_sizes() const {
  const bool fits = mean_.size() % 2 == 1 && P_.rows() == mean_.size() && P_.cols() == mean_.size();
  if (!fits) throw DataError("range_beacons: the sizes of a survey do not fit each other");
}

}  // namespace waymark::range_beacons
