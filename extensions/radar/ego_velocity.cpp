// SPDX-License-Identifier: Apache-2.0
#include "ego_velocity.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace waymark::radar {
namespace {

constexpr int kRefinements = 5;
// What is known of a velocity along directions in which no target lies; it keeps the equations regular.
constexpr double kUnknownSigma = 300.0;  // [m/s]
constexpr double kLeastCosine = 0.1;
constexpr double kLeastDeterminant = 1e-4;  // of a candidate's rays, which are nearly parallel below

double squared(double x) { return x * x; }

}  // namespace

void EgoVelocityEstimator::fill_rows(std::span<const RadarTargets::One> targets) {
  rows_.clear();
  rows_.reserve(targets.size());
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const RadarTargets::One& one = targets[i];
    if (one.range_m < settings_.min_range_m) continue;
    const double elevation = settings_.dimensions == 3 ? one.elevation_rad : 0.0;
    const double cos_az = std::cos(one.azimuth_rad);
    const double sin_az = std::sin(one.azimuth_rad);
    const double cos_el = std::cos(elevation);
    const double sin_el = std::sin(elevation);
    const Eigen::Vector3d ray(cos_el * cos_az, cos_el * sin_az, sin_el);
    // An array measures a phase, in proportion to the angle's sine.
    const double azimuth_sigma = settings_.azimuth_sigma_rad / std::max(kLeastCosine, std::abs(cos_az));
    const double elevation_sigma =
        settings_.dimensions == 3 ? settings_.elevation_sigma_rad / std::max(kLeastCosine, cos_el) : 0.0;
    const Eigen::Vector3d azimuth = azimuth_sigma * Eigen::Vector3d(-ray.y(), ray.x(), 0.0);
    const Eigen::Vector3d across = elevation_sigma * Eigen::Vector3d(-sin_el * cos_az, -sin_el * sin_az, cos_el);
    rows_.push_back({ray, azimuth, across, one.radial_mps, i});
  }
}

double EgoVelocityEstimator::variance(const Row& row, const Eigen::Vector3d& v) const {
  return squared(settings_.doppler_sigma_mps) + squared(row.azimuth.dot(v)) + squared(row.elevation.dot(v));
}

std::optional<Eigen::Vector3d> EgoVelocityEstimator::draw_candidate(Random& random) const {
  const auto d = static_cast<std::size_t>(settings_.dimensions);
  Eigen::Matrix3d A = Eigen::Matrix3d::Identity();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < d; ++k) {
    const auto at = static_cast<std::size_t>(random.uniform() * static_cast<double>(rows_.size()));
    const Row& row = rows_[std::min(at, rows_.size() - 1)];
    A.row(static_cast<Eigen::Index>(k)) = -row.ray.transpose();
    b(static_cast<Eigen::Index>(k)) = row.radial_mps;
  }
  if (std::abs(A.determinant()) < kLeastDeterminant) return std::nullopt;
  return A.inverse() * b;
}

double EgoVelocityEstimator::cost(const Eigen::Vector3d& v, double abandon_above) const {
  const double worst = squared(settings_.gate_sigma);
  const double white = squared(settings_.doppler_sigma_mps);
  double sum = 0.0;
  for (const Row& row : rows_) {
    const double s = variance(row, v);
    const double e = squared(row.radial_mps + row.ray.dot(v));
    // The logarithm makes a velocity pay for the width of its own gates.
    sum += e >= worst * s ? worst : std::min(worst, e / s + std::log(s / white));
    if (sum >= abandon_above) break;
  }
  return sum;
}

bool EgoVelocityEstimator::refine(EgoVelocity& velocity) {
  const double ridge = 1.0 / squared(kUnknownSigma);
  for (int iteration = 0; iteration < kRefinements; ++iteration) {
    Eigen::Matrix3d information = ridge * Eigen::Matrix3d::Identity();
    Eigen::Vector3d vector = Eigen::Vector3d::Zero();
    double chi2 = 0.0;
    velocity.inliers = 0;
    std::ranges::fill(flags_, std::uint8_t{0});
    for (const Row& row : rows_) {
      const double s = variance(row, velocity.v);
      const double e = row.radial_mps + row.ray.dot(velocity.v);
      if (e * e > squared(settings_.gate_sigma) * s) continue;
      information += row.ray * row.ray.transpose() / s;
      vector -= row.ray * (row.radial_mps / s);
      chi2 += e * e / s;
      flags_[row.target] = 1;
      ++velocity.inliers;
    }
    const auto d = static_cast<std::size_t>(settings_.dimensions);
    if (velocity.inliers <= d) return false;
    velocity.white = information.inverse();
    const Eigen::Vector3d next = velocity.white * vector;
    const double scatter = chi2 / static_cast<double>(velocity.inliers - d);
    velocity.white *= std::max(1.0, scatter);
    const bool settled = (next - velocity.v).norm() < 1e-4;
    velocity.v = next;
    if (settled) break;
  }
  const Eigen::Vector3d& v = velocity.v;
  const Eigen::Matrix3d across = v.squaredNorm() * Eigen::Matrix3d::Identity() - v * v.transpose();
  velocity.shared = static_cast<double>(velocity.inliers - 1) * settings_.correlation * velocity.white +
                    squared(settings_.scan_sigma_rad) * across;
  velocity.shared.diagonal().array() += squared(settings_.scan_sigma_mps);
  if (settings_.dimensions == 2) {
    velocity.v.z() = 0.0;
    for (Eigen::Matrix3d* covariance : {&velocity.white, &velocity.shared}) {
      covariance->row(2).setZero();
      covariance->col(2).setZero();
    }
  }
  return true;
}

EgoVelocity EgoVelocityEstimator::estimate(std::span<const RadarTargets::One> targets, Random random) {
  EgoVelocity velocity;
  fill_rows(targets);
  flags_.assign(targets.size(), 0);
  velocity.used = rows_.size();
  if (velocity.used <= static_cast<std::size_t>(settings_.dimensions)) return velocity;

  double best = std::numeric_limits<double>::infinity();
  for (int draw = 0; draw < settings_.draws; ++draw) {
    const std::optional<Eigen::Vector3d> candidate = draw_candidate(random);
    if (!candidate) continue;
    const double c = cost(*candidate, best);
    if (c >= best) continue;
    best = c;
    velocity.v = *candidate;
  }
  if (!std::isfinite(best) || !refine(velocity)) velocity.inliers = 0;
  return velocity;
}

bool EgoVelocityEstimator::believed(const EgoVelocity& velocity) const {
  return velocity.inliers >= std::max(settings_.min_inliers, static_cast<std::size_t>(settings_.dimensions) + 1) &&
         velocity.share() >= settings_.min_share;
}

}  // namespace waymark::radar
