// SPDX-License-Identifier: Apache-2.0
#include "ring.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "waymark/math/gaussian.hpp"

namespace waymark::range_beacons {
namespace {

constexpr int kFewestPlaces = 8;
constexpr int kMostPlaces = 96;
constexpr double kOverlap = 1.2;       // σ along the ring from one place to the next
constexpr double kNegligible = -12.0;  // log weight, against the best, below which a place goes
constexpr double kSamePlace = 1.0;     // Mahalanobis distance below which two places become one
constexpr double kNearest = 1e-3;      // [m]

double log_normal(double nu, double variance) {
  return -0.5 * (nu * nu / variance + std::log(2.0 * std::numbers::pi * variance));
}

double pose_variance(const Eigen::RowVector2d& by_antenna, const Antenna& antenna, const Eigen::Matrix3d& pose_P) {
  const Eigen::RowVector3d G = by_antenna * antenna.by_pose;
  return G * pose_P * G.transpose();
}

/// The expected range at a place: distance, direction to the antenna, and its second-order term (the mean and variance
/// of what the curvature of the distance adds; M. Athans, R. Wishner, A. Bertolini, IEEE Transactions on Automatic
/// Control 13(5), 1968).
struct Geometry {
  Geometry(const Place& place, const Eigen::Vector2d& p_map_antenna) {
    const Eigen::Vector2d d = p_map_antenna - place.mean.head<2>();
    distance = std::max(d.norm(), kNearest);
    unit = d / distance;
    const double k = place.mean[2];
    const Eigen::Vector2d across(-unit.y(), unit.x());
    const double variance_across = across.dot(place.P.topLeftCorner<2, 2>() * across);
    const double bend = k * variance_across / std::max(distance, std::sqrt(variance_across));
    bias = 0.5 * bend;
    bias_variance = 0.5 * bend * bend;
    H << -k * unit.x(), -k * unit.y(), distance;
  }
  double distance;
  Eigen::Vector2d unit;
  double bias;
  double bias_variance;
  Eigen::RowVector3d H;  ///< by east, north, scale
};

}  // namespace

PredictedRange Place::predict(double range, double sigma, const Eigen::Vector2d& p_map_antenna) const {
  const Geometry at(*this, p_map_antenna);
  const double expected = mean[2] * at.distance + at.bias;
  const double variance = at.H * P * at.H.transpose() + at.bias_variance + sigma * sigma;
  return {range - expected, variance, at.distance, mean[2] * at.unit.transpose()};
}

void Place::update(double range, double sigma, const Eigen::Vector2d& p_map_antenna, double pose_variance) {
  const Geometry at(*this, p_map_antenna);
  const double nu = range - mean[2] * at.distance - at.bias;
  const Eigen::Vector3d PHt = P * at.H.transpose();
  const double S = at.H.dot(PHt) + at.bias_variance + sigma * sigma + pose_variance;
  mean += PHt * (nu / S);
  P -= PHt * PHt.transpose() / S;
}

Ring::Ring(double range, double sigma, const Antenna& antenna, const Eigen::Matrix3d& pose_P, double scale,
           double scale_variance)
    : first_scale_(scale), first_scale_variance_(scale_variance) {
  const double radius = std::max(range / scale, kNearest);
  const Eigen::Matrix2d antenna_P = antenna.by_pose * pose_P * antenna.by_pose.transpose();
  const double sigma_radial = std::sqrt(sigma * sigma / (scale * scale) + 0.5 * antenna_P.trace());
  // So wide that the arc leaves its tangent by half the radial σ.
  const double widest = std::sqrt(radius * sigma_radial);
  const auto fits = static_cast<int>(std::ceil(2.0 * std::numbers::pi * radius / (kOverlap * widest)));
  const int count = std::clamp(fits, kFewestPlaces, kMostPlaces);
  const double along = 2.0 * std::numbers::pi * radius / (kOverlap * count);
  places_.resize(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / count;
    const Eigen::Vector2d unit(std::cos(angle), std::sin(angle));
    const Eigen::Vector2d across(-unit.y(), unit.x());
    Place& place = places_[static_cast<std::size_t>(i)];
    place.mean << antenna.p + radius * unit, scale;
    // A larger scale means a smaller radius: ∂b/∂k = −(radius/k) unit.
    const Eigen::Vector2d by_scale = -radius / scale * unit;
    place.P.topLeftCorner<2, 2>() = sigma_radial * sigma_radial * unit * unit.transpose() +
                                    along * along * across * across.transpose() +
                                    scale_variance * by_scale * by_scale.transpose();
    place.P.topRightCorner<2, 1>() = scale_variance * by_scale;
    place.P.bottomLeftCorner<1, 2>() = scale_variance * by_scale.transpose();
    place.P(2, 2) = scale_variance;
    place.log_weight = -std::log(static_cast<double>(count));
  }
}

double Ring::log_evidence(double range, double sigma, const Antenna& antenna, const Eigen::Matrix3d& pose_P) const {
  std::vector<double> logs;
  logs.reserve(places_.size());
  for (const Place& place : places_) {
    const PredictedRange seen = place.predict(range, sigma, antenna.p);
    logs.push_back(place.log_weight +
                   log_normal(seen.nu, seen.variance + pose_variance(seen.by_antenna, antenna, pose_P)));
  }
  return gaussian::log_sum_exp(logs.data(), static_cast<int>(logs.size()));
}

void Ring::update(double range, double sigma, const Antenna& antenna, const Eigen::Matrix3d& pose_P) {
  for (Place& place : places_) {
    const PredictedRange seen = place.predict(range, sigma, antenna.p);
    const double by_pose = pose_variance(seen.by_antenna, antenna, pose_P);
    place.log_weight += log_normal(seen.nu, seen.variance + by_pose);
    place.update(range, sigma, antenna.p, by_pose);
  }
  normalise();
  merge();
}

void Ring::normalise() {
  std::ranges::sort(places_, std::greater{}, &Place::log_weight);
  const double best = places_.front().log_weight;
  std::erase_if(places_, [&](const Place& place) { return !(place.log_weight > best + kNegligible); });
  double sum = 0.0;
  for (const Place& place : places_) sum += std::exp(place.log_weight - best);
  for (Place& place : places_) place.log_weight -= best + std::log(sum);
}

namespace {

/// The Gaussian with the moments of two.
Place joined(const Place& a, const Place& b) {
  const double total =
      std::max(a.log_weight, b.log_weight) + std::log1p(std::exp(-std::abs(a.log_weight - b.log_weight)));
  const double share = std::exp(b.log_weight - total);
  const Eigen::Vector3d d = b.mean - a.mean;
  Place out;
  out.log_weight = total;
  out.mean = a.mean + share * d;
  out.P = (1.0 - share) * a.P + share * b.P + share * (1.0 - share) * d * d.transpose();
  return out;
}

}  // namespace

/// The places are in order of weight: each takes in those behind it that are at the same place.
void Ring::merge() {
  for (std::size_t i = 0; i + 1 < places_.size(); ++i) {
    for (std::size_t j = places_.size() - 1; j > i; --j) {
      const Eigen::Vector2d d = (places_[j].mean - places_[i].mean).head<2>();
      const Eigen::Matrix2d P = places_[i].P.topLeftCorner<2, 2>() + places_[j].P.topLeftCorner<2, 2>();
      if (d.dot(P.inverse() * d) > 2.0 * kSamePlace * kSamePlace) continue;
      // Neighbours on a wide arc are not one Gaussian yet.
      if (d.squaredNorm() > places_[i].P.topLeftCorner<2, 2>().trace() && places_.size() > kFewestPlaces) continue;
      places_[i] = joined(places_[i], places_[j]);
      places_.erase(places_.begin() + static_cast<std::ptrdiff_t>(j));
    }
  }
}

Place Ring::collapsed() const {
  Place out = places_.front();
  for (std::size_t i = 1; i < places_.size(); ++i) out = joined(out, places_[i]);
  return out;
}

}  // namespace waymark::range_beacons
