// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/evaluation/outages.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <string>

#include "waymark/base/error.hpp"

namespace waymark::evaluation {
namespace {

using Point = Trajectory::Point;
using Iterator = std::vector<Point>::const_iterator;

/// The first point that is not before `time`.
Iterator from(const Trajectory& trajectory, Time time) {
  return std::ranges::lower_bound(trajectory.points, time, {}, &Point::stamp);
}

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The pose at `time`, predicted from the estimates before `next`: the last one, moved on at the median velocity of the
/// last quarter of a second. The median tolerates that one of them stepped itself. Absent if there are too few.
std::optional<Pose> predicted(const Trajectory& estimate, Iterator next, Time time) {
  constexpr double kWindow = 0.25;  // [s]
  constexpr double kLongest = 2.0;  // [s], of a window of few poses
  constexpr std::size_t kFewest = 3;
  if (next == estimate.points.begin()) return std::nullopt;
  const Iterator last = std::prev(next);
  std::array<std::vector<double>, 3> velocities;  // forward, to the left, turning
  for (Iterator point = last; point != estimate.points.begin(); --point) {
    const double age = to_seconds(last->stamp - std::prev(point)->stamp);
    if (age > kLongest || (age > kWindow && velocities[0].size() >= kFewest)) break;
    const double dt = to_seconds(point->stamp - std::prev(point)->stamp);
    const Pose step = std::prev(point)->pose.inverse() * point->pose;
    const Eigen::Vector3d along = so3::from_rpy(0.0, 0.0, -0.5 * step.yaw()) * step.p;  // as the chord of an arc
    velocities[0].push_back(along.x() / dt);
    velocities[1].push_back(along.y() / dt);
    velocities[2].push_back(step.yaw() / dt);
  }
  if (velocities[0].size() < kFewest) return std::nullopt;
  const double dt = to_seconds(time - last->stamp);
  const double turn = dt * median(velocities[2]);
  const Eigen::Vector3d along(dt * median(velocities[0]), dt * median(velocities[1]), 0.0);
  return last->pose * Pose{so3::from_rpy(0.0, 0.0, turn), so3::from_rpy(0.0, 0.0, 0.5 * turn) * along};
}

/// The covariance of the position that is known before `time`, turned into the reference's frame.
std::optional<Eigen::Matrix2d> position_covariance(const std::vector<PoseCovariance>& covariances, Time time,
                                                   const Pose& T_reference_estimate) {
  const auto next = std::ranges::lower_bound(covariances, time, {}, &PoseCovariance::stamp);
  if (next == covariances.begin()) return std::nullopt;
  const Eigen::Matrix2d turn = T_reference_estimate.q.toRotationMatrix().topLeftCorner<2, 2>();
  return turn * std::prev(next)->P.topLeftCorner<2, 2>() * turn.transpose();
}

std::optional<double> in_sigma(const Eigen::Vector2d& error, const std::optional<Eigen::Matrix2d>& P) {
  if (!P) return std::nullopt;
  const Eigen::LLT<Eigen::Matrix2d> factor(*P);
  if (factor.info() != Eigen::Success) return std::nullopt;
  return std::sqrt(error.dot(factor.solve(error)));
}

/// Scores one outage.
class Scorer {
 public:
  Scorer(const Trajectory& estimate, const Trajectory& reference, const std::vector<PoseCovariance>& covariances,
         const Pose& T_reference_estimate, const OutageOptions& options)
      : estimate_(estimate),
        reference_(reference),
        covariances_(covariances),
        T_reference_estimate_(T_reference_estimate),
        lever_{Eigen::Quaterniond::Identity(), options.lever_arm_m},
        options_(options) {}

  OutageError score(const Outage& outage) const {
    OutageError out;
    out.outage = outage;
    for (Iterator point = from(estimate_, outage.begin); point != from(estimate_, outage.end); ++point)
      widen(out.position_max_m, error(point->pose, point->stamp));
    if (const auto end = predicted(estimate_, from(estimate_, outage.end), outage.end)) score_end(*end, out);
    score_steps(out);
    return out;
  }

 private:
  /// Position of the estimate less that of the reference; absent if the truth is not known at that time.
  std::optional<Eigen::Vector2d> error(const Pose& pose, Time stamp) const {
    Pose truth;
    if (pose_at(reference_, stamp, options_.max_time_gap_s, truth) != Lookup::found) return std::nullopt;
    return (T_reference_estimate_ * pose * lever_).p.head<2>() - truth.p.head<2>();
  }

  static void widen(std::optional<double>& largest, const std::optional<Eigen::Vector2d>& error) {
    if (error) largest = std::max(largest.value_or(0.0), error->norm());
  }

  void score_end(const Pose& end, OutageError& out) const {
    const auto P = position_covariance(covariances_, out.outage.end, T_reference_estimate_);
    if (P) {
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(*P, Eigen::EigenvaluesOnly);
      out.sigma_end_m = std::sqrt(std::max(0.0, axes.eigenvalues().y()));
    }
    const auto wrong = error(end, out.outage.end);
    if (!wrong) return;
    widen(out.position_max_m, wrong);
    out.position_end_m = wrong->norm();
    out.error_end_sigma = in_sigma(*wrong, P);
    Pose truth;
    const bool both_turn = estimate_.orientation != Orientation::none && reference_.orientation != Orientation::none;
    if (both_turn && pose_at(reference_, out.outage.end, options_.max_time_gap_s, truth) == Lookup::found)
      out.yaw_end_rad = so3::wrap((T_reference_estimate_ * end).yaw() - truth.yaw());
  }

  void score_steps(OutageError& out) const {
    const Time settled = out.outage.end + from_seconds(options_.settling_s);
    for (Iterator point = from(estimate_, out.outage.end); point != estimate_.points.end(); ++point) {
      if (point->stamp > settled) break;
      const auto before = predicted(estimate_, point, point->stamp);
      if (!before) continue;
      const Eigen::Vector2d step = (point->pose.p - before->p).head<2>();
      out.step_m = std::max(out.step_m.value_or(0.0), step.norm());
      if (const auto sigma = in_sigma(step, position_covariance(covariances_, point->stamp, Pose{})))
        out.step_sigma = std::max(out.step_sigma.value_or(0.0), *sigma);
    }
  }

  const Trajectory& estimate_;
  const Trajectory& reference_;
  const std::vector<PoseCovariance>& covariances_;
  Pose T_reference_estimate_;
  Pose lever_;
  OutageOptions options_;
};

}  // namespace

Outage parse_outage(std::string_view text) {
  const auto fail = [&]() -> Outage {
    throw Error(fmt::format("--outage {}: begin:end in seconds is expected, such as 30:45", text));
  };
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos) return fail();
  try {
    const Outage outage{parse_time(text.substr(0, colon)), parse_time(text.substr(colon + 1))};
    return outage.begin < outage.end ? outage : fail();
  } catch (const DataError&) {
    return fail();
  }
}

std::vector<Outage> pauses(const Trajectory& recording, double longer_than_s) {
  std::vector<Outage> out;
  for (std::size_t i = 1; i < recording.points.size(); ++i) {
    const Outage pause{recording.points[i - 1].stamp, recording.points[i].stamp};
    if (to_seconds(pause.end - pause.begin) > longer_than_s) out.push_back(pause);
  }
  return out;
}

std::vector<OutageError> score_outages(const std::vector<Outage>& outages, const Trajectory& estimate,
                                       const Trajectory& reference, const std::vector<PoseCovariance>& covariances,
                                       const Pose& T_reference_estimate, const OutageOptions& options) {
  const Scorer scorer(estimate, reference, covariances, T_reference_estimate, options);
  std::vector<OutageError> out;
  out.reserve(outages.size());
  for (const Outage& outage : outages) out.push_back(scorer.score(outage));
  return out;
}

}  // namespace waymark::evaluation
