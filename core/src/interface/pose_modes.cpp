// SPDX-License-Identifier: Apache-2.0
#include "waymark/interface/pose_modes.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "waymark/math/so3.hpp"

namespace waymark {

namespace {

/// Weighted moments of one number.
struct WeightedSums {
  double weight = 0.0;
  double first = 0.0;
  double second = 0.0;

  void add(double value, double by) {
    weight += by;
    first += by * value;
    second += by * value * value;
  }
  double mean() const { return first / weight; }
  double variance() const { return std::max(second / weight - mean() * mean(), 0.0); }
};

}  // namespace

const std::vector<PoseMode>& ModeFinder::find(std::span<const ParticleView> particles) {
  modes_.clear();
  points_.clear();
  if (particles.empty()) return modes_;
  const Pose& first = particles.front().T_map_base;
  const double yaw = so3::yaw(first.q);
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const Pose& pose = particles[i].T_map_base;
    // Relative to the first one: sums of squares keep their digits far from the origin.
    const Eigen::Vector2d p = pose.p.head<2>() - first.p.head<2>();
    points_.push_back({{p.x(), p.y(), kHeadingArm * so3::wrap(so3::yaw(pose.q) - yaw)}, particles[i].weight, 0.0, i});
  }
  divide(points_, particles);
  std::ranges::sort(modes_, [](const PoseMode& a, const PoseMode& b) { return a.weight > b.weight; });
  return modes_;
}

void ModeFinder::divide(std::span<Point> points, std::span<const ParticleView> particles) {
  const std::size_t at = cut(points);
  if (at > 0) {
    divide(points.first(at), particles);
    divide(points.subspan(at), particles);
    return;
  }
  const auto heaviest = std::ranges::max_element(points, {}, &Point::weight);
  double weight = 0.0;
  for (const Point& point : points) weight += point.weight;
  modes_.push_back({particles[heaviest->particle].T_map_base, weight});
}

/// Number of the points before the cut, in their order along the greatest spread, in which they are left; 0: none.
std::size_t ModeFinder::cut(std::span<Point> points) {
  double weight = 0.0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Point& point : points) {
    weight += point.weight;
    mean += point.weight * point.at;
  }
  if (weight < 2.0 * kLeastWeight) return 0;
  mean /= weight;
  Eigen::Matrix3d P = Eigen::Matrix3d::Zero();
  for (const Point& point : points) P += point.weight * (point.at - mean) * (point.at - mean).transpose();
  if (P.trace() < kLeastVariance * weight) return 0;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(P);
  WeightedSums above;
  for (Point& point : points) {
    point.along = axes.eigenvectors().col(2).dot(point.at - mean);
    above.add(point.along, point.weight);
  }
  std::ranges::sort(points, [](const Point& a, const Point& b) {
    return a.along != b.along ? a.along < b.along : a.particle < b.particle;
  });
  WeightedSums below;
  double best = kLeastD * (1.0 + kFew / static_cast<double>(points.size()));
  std::size_t before = 0;
  for (std::size_t k = 0; k + 1 < points.size(); ++k) {
    below.add(points[k].along, points[k].weight);
    above.add(points[k].along, -points[k].weight);
    if (below.weight < kLeastWeight || above.weight < kLeastWeight) continue;
    constexpr double kLeast = kLeastSigma * kLeastSigma;
    const double variance = std::max(below.variance(), kLeast) + std::max(above.variance(), kLeast);
    const double d = std::sqrt(2.0 / variance) * std::abs(above.mean() - below.mean());
    if (d > best) {
      best = d;
      before = k + 1;
    }
  }
  return before;
}

}  // namespace waymark
