// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/run_views/reference_frame.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace waymark::run_views {
namespace {

struct Pair {
  const Estimate* estimate;
  Pose reference;
};

double wrapped(double angle) { return std::remainder(angle, 2.0 * std::numbers::pi); }

/// Least squares in the plane; nothing if the points do not determine a rotation.
std::optional<Pose> fit(const std::vector<Pair>& pairs) {
  Eigen::Vector3d mean_reference = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_estimate = Eigen::Vector3d::Zero();
  for (const Pair& pair : pairs) {
    mean_reference += pair.reference.p;
    mean_estimate += pair.estimate->T_map_base.p;
  }
  mean_reference /= static_cast<double>(pairs.size());
  mean_estimate /= static_cast<double>(pairs.size());
  double dot = 0.0;
  double cross = 0.0;
  double spread = 0.0;
  for (const Pair& pair : pairs) {
    const Eigen::Vector3d a = pair.reference.p - mean_reference;
    const Eigen::Vector3d b = pair.estimate->T_map_base.p - mean_estimate;
    dot += a.x() * b.x() + a.y() * b.y();
    cross += a.x() * b.y() - a.y() * b.x();
    spread += 0.5 * (a.head<2>().squaredNorm() + b.head<2>().squaredNorm());
  }
  constexpr double kDegenerate = 1e-9;
  if (!(std::hypot(dot, cross) > kDegenerate * spread)) return std::nullopt;
  Pose T = Pose::planar(0.0, 0.0, std::atan2(cross, dot));
  T.p = mean_estimate - T.q * mean_reference;
  return T;
}

double rms(const std::vector<Pair>& pairs, const Pose& T_map_reference) {
  double sum = 0.0;
  for (const Pair& pair : pairs)
    sum += (T_map_reference * pair.reference.p - pair.estimate->T_map_base.p).head<2>().squaredNorm();
  return std::sqrt(sum / static_cast<double>(pairs.size()));
}

}  // namespace

ReferenceLookup::ReferenceLookup(const Reference& reference) : points_(reference.trajectory) {
  std::vector<Duration> steps;
  for (std::size_t i = 1; i < points_.size(); ++i) steps.push_back(points_[i].stamp - points_[i - 1].stamp);
  if (steps.empty()) return;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  longest_step_ = std::max<Duration>(from_seconds(1.0), std::min<Duration>(*middle, from_seconds(1e6)) * 10);
}

bool ReferenceLookup::is_pause(std::size_t after) const {
  return after + 1 < points_.size() && points_[after + 1].stamp - points_[after].stamp > longest_step_;
}

std::optional<Pose> ReferenceLookup::at(Time stamp) const {
  const auto next = std::ranges::lower_bound(points_, stamp, {}, &Reference::Point::stamp);
  if (next == points_.end()) return std::nullopt;
  if (next->stamp == stamp) return next->T_map_base;
  if (next == points_.begin()) return std::nullopt;
  const auto before = std::prev(next);
  const Duration step = next->stamp - before->stamp;
  if (step > longest_step_) return std::nullopt;
  const double share = to_seconds(stamp - before->stamp) / to_seconds(step);
  const Pose& a = before->T_map_base;
  const Pose& b = next->T_map_base;
  return Pose{a.q.slerp(share, b.q), a.p + share * (b.p - a.p)};
}

ReferenceFrame frame_of(const Reference& reference, const std::vector<Estimate>& estimates) {
  const ReferenceLookup lookup(reference);
  std::vector<Pair> pairs;
  for (const Estimate& estimate : estimates) {
    const auto pose = lookup.at(estimate.stamp);
    if (pose && pose->p.allFinite() && estimate.T_map_base.p.allFinite()) pairs.push_back({&estimate, *pose});
  }
  constexpr std::size_t kFewest = 10;
  if (pairs.size() < kFewest) return {};
  const auto T_map_reference = fit(pairs);
  if (!T_map_reference) return {};
  const bool has_yaw = std::ranges::all_of(reference.trajectory, &Reference::Point::has_yaw);
  const Pair& first = pairs.front();
  constexpr double kSigmas = 5.0;
  const double away = (first.reference.p - first.estimate->T_map_base.p).head<2>().norm();
  const double turned = std::abs(wrapped(first.reference.yaw() - first.estimate->T_map_base.yaw()));
  const bool contradicts = away > kSigmas * first.estimate->sigma_position_m ||
                           (has_yaw && turned > kSigmas * first.estimate->sigma_yaw_rad);
  const double share = rms(pairs, *T_map_reference) / rms(pairs, Pose());
  const bool is_other_frame = (contradicts && share < 1.0 / 3.0) || (!has_yaw && share < 0.1);
  if (!is_other_frame) return {};
  return {*T_map_reference, true};
}

std::shared_ptr<const Reference> in_map(std::shared_ptr<const Reference> reference, const ReferenceFrame& frame) {
  if (reference == nullptr || !frame.is_aligned) return reference;
  auto moved = std::make_shared<Reference>(*reference);
  for (Reference::Point& point : moved->trajectory) point.T_map_base = frame.T_map_reference * point.T_map_base;
  for (Reference::Landmark& landmark : moved->landmarks) {
    const Eigen::Vector3d p(landmark.p_map.x(), landmark.p_map.y(), 0.0);
    landmark.p_map = (frame.T_map_reference * p).head<2>();
  }
  return moved;
}

}  // namespace waymark::run_views
