// SPDX-License-Identifier: Apache-2.0
#include "map_modules/octomap_grid/surfels/surfel_matcher.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "waymark/math/so3.hpp"

namespace waymark::octomap_grid {

namespace {

constexpr double kScale = 0.25;     // of a cell: residuals of this size count a quarter
constexpr double kLastScale = 3.0;  // σ of the narrow field
constexpr double kHeadingStep = 15.0 * std::numbers::pi / 180.0;

Pose moved(const Pose& mean, const SpatialVector& d) {
  return {(so3::exp(d.tail<3>()) * mean.q).normalized(), mean.p + d.head<3>()};
}

/// (Λ⁻¹ + F)⁻¹ with F = diag(floor²), for a Λ that may be singular.
SpatialMatrix with_floor(const SpatialMatrix& information, const SpatialVector& floor) {
  const SpatialMatrix white = floor.asDiagonal() * information * floor.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<SpatialMatrix> eigen(white);
  const SpatialVector values = eigen.eigenvalues().cwiseMax(0.0);
  const SpatialVector kept = values.array() / (1.0 + values.array());
  const SpatialVector back = floor.cwiseInverse();
  const SpatialMatrix bounded = eigen.eigenvectors() * kept.asDiagonal() * eigen.eigenvectors().transpose();
  const SpatialMatrix result = back.asDiagonal() * bounded * back.asDiagonal();
  return 0.5 * (result + result.transpose());
}

}  // namespace

SurfelWindow::Plane SurfelMatcher::nearest(int level, const Eigen::Vector3d& p) const {
  SurfelWindow::Plane plane{nullptr, Eigen::Vector3d::Zero()};
  for (; plane.surfel == nullptr && level < SurfelMap::kLevels; ++level)
    plane = windows_[static_cast<std::size_t>(level)].nearest(p);
  return plane;
}

PlaneFit SurfelMatcher::fit(int level, const SpatialPrior& prior, const SpatialVector& d, double scale) {
  const Pose T_map_base = moved(prior.mean, d);
  const Eigen::Matrix3d R = T_map_base.q.toRotationMatrix();
  // d is a rotation vector: a small turn after it is a change of d by the inverse of this.
  const Eigen::Matrix3d J_turn = so3::left_jacobian(d.tail<3>());
  const double noise = settings_->narrow_sigma * settings_->narrow_sigma;
  PlaneFit out;
  double sum = 0.0;
  used_.clear();
  for (const Eigen::Vector3f& point : points_) {
    const Eigen::Vector3d arm = R * point.cast<double>();
    const Eigen::Vector3d p = arm + T_map_base.p;
    const SurfelWindow::Plane plane = nearest(level, p);
    double likelihood = 0.0;
    if (plane.surfel != nullptr) {
      const Eigen::Vector3d normal = plane.surfel->normal.cast<double>();
      const double r = normal.dot(p - plane.middle);
      const double variance = noise + static_cast<double>(plane.surfel->variance);
      const double keep = scale * scale / (scale * scale + r * r);
      const double w = keep * keep / variance;
      SpatialVector J;
      J << normal, J_turn.transpose() * arm.cross(normal);
      out.information.noalias() += w * J * J.transpose();
      out.descent.noalias() -= w * r * J;
      likelihood = std::exp(-0.5 * r * r / variance);
      used_.push_back(plane.surfel);
    }
    sum += likelihood;
    out.log_likelihood += std::log(0.9 * likelihood + 0.1);
  }
  if (points_.empty() || used_.empty()) return out;
  out.score = sum / static_cast<double>(points_.size());
  // Points of one plane share its error.
  std::ranges::sort(used_);
  const auto points = static_cast<double>(used_.size());
  const auto planes = static_cast<double>(std::unique(used_.begin(), used_.end()) - used_.begin());
  out.information *= planes / points;
  out.descent *= planes / points;
  return out;
}

void SurfelMatcher::descend(int level, const SpatialPrior& prior, double scale, bool is_last, Optimum& at) {
  // Steps below these end a stage: m and rad.
  const double least = is_last ? 2e-4 : 3e-3;
  for (int i = 0; i < settings_->max_iterations; ++i) {
    at.fit = fit(level, prior, at.d, scale);
    const SpatialVector gradient = at.fit.information * at.d + at.fit.descent;
    at.pull = (SpatialMatrix::Identity() + at.fit.information * prior.P).partialPivLu().solve(gradient);
    const SpatialVector next = prior.P * at.pull;
    const double step = (next - at.d).cwiseAbs().maxCoeff();
    at.d = next;
    if (!(step > least)) break;
  }
}

SurfelMatcher::Optimum SurfelMatcher::descend_from(const SpatialPrior& prior, const SpatialVector& start) {
  Optimum at;
  at.d = start;
  for (int level = SurfelMap::kLevels - 1; level >= 0; --level)
    descend(level, prior, kScale * windows_[static_cast<std::size_t>(level)].cell(), false, at);
  descend(0, prior, kLastScale * settings_->narrow_sigma, true, at);
  return at;
}

SpatialVector SurfelMatcher::best_heading(const SpatialPrior& prior) {
  constexpr int kLargest = SurfelMap::kLevels - 1;
  const double scale = kScale * windows_.back().cell();
  const int steps = static_cast<int>(settings_->coarse_angle / kHeadingStep);
  SpatialVector best = SpatialVector::Zero();
  double best_score = -1.0;
  for (int i = -steps; i <= steps; ++i) {
    Optimum at;
    at.d[5] = i * kHeadingStep;
    descend(kLargest, prior, scale, false, at);
    const double score = at.d.allFinite() ? fit(0, prior, at.d, scale).score : 0.0;
    if (score <= best_score) continue;
    best_score = score;
    best = at.d;
  }
  return best;
}

SpatialMatch SurfelMatcher::match(const SurfelMap& map, double cell, std::span<const Eigen::Vector3f> points,
                                  double reach, const SpatialPrior& prior,
                                  const scan_matching::MatchSettings& settings) {
  points_ = points;
  settings_ = &settings;
  // A start that is farther away than the scan reaches matches nothing.
  const double around = reach + settings.coarse_distance + std::min(prior.start.head<3>().norm(), reach);
  for (int level = 0; level < SurfelMap::kLevels; ++level) {
    windows_[static_cast<std::size_t>(level)].open(map.level(level), SurfelMap::cell_of(level, cell), prior.mean.p,
                                                   around);
  }
  const auto is_failed = [&](const Optimum& at) { return !at.d.allFinite() || at.fit.score < settings.min_score; };
  Optimum optimum = descend_from(prior, prior.start);
  SpatialMatch match;
  match.searched = is_failed(optimum) || optimum.fit.score < settings.search_score;
  if (match.searched) {
    const Optimum other = descend_from(prior, best_heading(prior));
    if (!is_failed(other) && (is_failed(optimum) || other.fit.score > optimum.fit.score)) optimum = other;
  }
  match.failed = is_failed(optimum);
  if (match.failed) {
    const PlaneFit alone = fit(0, prior, SpatialVector::Zero(), kLastScale * settings.narrow_sigma);
    match.score = alone.score;
    match.log_evidence = settings.evidence_tempering * alone.log_likelihood;
    return match;
  }
  SpatialVector floor;
  floor << settings.floor.head<2>(), settings.floor.x(), Eigen::Vector3d::Constant(settings.floor.z());
  match.d = optimum.d;
  match.score = optimum.fit.score;
  match.information = with_floor(optimum.fit.information, floor);
  match.gradient = match.information * optimum.d + optimum.pull;
  match.log_evidence = settings.evidence_tempering * optimum.fit.log_likelihood - 0.5 * optimum.pull.dot(optimum.d);
  return match;
}

}  // namespace waymark::octomap_grid
