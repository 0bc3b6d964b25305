// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/evaluation/trajectory_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "waymark/base/error.hpp"

namespace waymark::evaluation {
namespace {

using Pair = PosePair;

/// A planar filter keeps the height of its start.
bool has_one_height(const Trajectory& trajectory) {
  constexpr double kResolutionM = 1e-6;  // of the files
  const double height = trajectory.points.front().pose.p.z();
  return std::ranges::all_of(trajectory.points, [&](const Trajectory::Point& point) {
    return std::abs(point.pose.p.z() - height) < kResolutionM;
  });
}

Pose interpolate(const Trajectory::Point& a, const Trajectory::Point& b, Time stamp) {
  const double share = to_seconds(stamp - a.stamp) / to_seconds(b.stamp - a.stamp);
  return {a.pose.q.slerp(share, b.pose.q), a.pose.p + share * (b.pose.p - a.pose.p)};
}

std::string span_text(const Trajectory& trajectory) {
  return fmt::format("{} covers {} s to {} s", trajectory.name, format_time(trajectory.points.front().stamp),
                     format_time(trajectory.points.back().stamp));
}

std::vector<Pair> associate(const Trajectory& estimate, const Trajectory& reference, double max_time_gap_s,
                            TrajectoryError& counts) {
  std::vector<Pair> pairs;
  for (const Trajectory::Point& point : reference.points) {
    Pose pose;
    switch (pose_at(estimate, point.stamp, max_time_gap_s, pose)) {
      case Lookup::found:
        pairs.push_back({point.stamp, pose, point.pose});
        break;
      case Lookup::outside:
        ++counts.outside;
        break;
      case Lookup::in_gap:
        ++counts.in_gap;
        break;
    }
  }
  if (pairs.empty()) {
    throw Error(
        fmt::format("no common time within {} s: {}; {}", max_time_gap_s, span_text(estimate), span_text(reference)));
  }
  return pairs;
}

Pose align(const std::vector<Pair>& pairs, Alignment kind) {
  if (kind == Alignment::se2) {
    std::vector<Eigen::Vector2d> from;
    std::vector<Eigen::Vector2d> to;
    for (const Pair& pair : pairs) {
      from.emplace_back(pair.estimate.p.head<2>());
      to.emplace_back(pair.reference.p.head<2>());
    }
    return fit_se2(from, to);
  }
  if (kind == Alignment::se3) {
    std::vector<Eigen::Vector3d> from;
    std::vector<Eigen::Vector3d> to;
    for (const Pair& pair : pairs) {
      from.push_back(pair.estimate.p);
      to.push_back(pair.reference.p);
    }
    return fit_se3(from, to);
  }
  return {};
}

Pose flattened(const Pose& pose) { return Pose::planar(pose.p.x(), pose.p.y(), pose.yaw()); }

RelativeError relative_error(const std::vector<Pair>& pairs, const TrajectoryOptions& options, bool rotations) {
  std::vector<double> along;  // what the delta counts: path of the reference [m], or time [s]
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (options.rpe_delta_s) {
      along.push_back(to_seconds(pairs[i].stamp - pairs.front().stamp));
    } else {
      along.push_back(i == 0 ? 0.0 : along.back() + (pairs[i].reference.p - pairs[i - 1].reference.p).norm());
    }
  }
  const double delta = options.rpe_delta_s.value_or(options.rpe_delta_m);
  RelativeError out;
  std::vector<double> translations;
  std::vector<double> angles;
  std::size_t j = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    // Rounding in the sums must not push a pair that is exactly one delta apart to the next sample.
    while (j < pairs.size() && along[j] - along[i] < delta * (1.0 - 1e-9)) ++j;
    if (j == pairs.size()) break;
    const double real_delta = along[j] - along[i];
    if (real_delta > 2.0 * delta) continue;
    if (rotations) {
      const Pose moved_reference = pairs[i].reference.inverse() * pairs[j].reference;
      const Pose moved_estimate = pairs[i].estimate.inverse() * pairs[j].estimate;
      const Pose error = moved_reference.inverse() * moved_estimate;
      translations.push_back(error.p.norm());
      angles.push_back(so3::log(error.q).norm());
    } else {
      translations.push_back(
          ((pairs[j].estimate.p - pairs[i].estimate.p) - (pairs[j].reference.p - pairs[i].reference.p)).norm());
    }
    out.mean_delta += real_delta;
  }
  out.pairs = translations.size();
  if (out.pairs > 0) out.mean_delta /= static_cast<double>(out.pairs);
  out.translation_m = statistics(std::move(translations));
  if (rotations) out.rotation_rad = statistics(std::move(angles));
  return out;
}

}  // namespace

double median_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

ErrorStatistics statistics(std::vector<double> values) {
  ErrorStatistics out;
  if (values.empty()) return out;
  double squares = 0.0;
  for (double& value : values) {
    value = std::abs(value);
    squares += value * value;
    out.mean += value;
  }
  const auto count = static_cast<double>(values.size());
  out.rms = std::sqrt(squares / count);
  out.mean /= count;
  out.max = *std::max_element(values.begin(), values.end());
  out.median = median_of(std::move(values));
  return out;
}

Lookup pose_at(const Trajectory& trajectory, Time stamp, double max_time_gap_s, Pose& out) {
  const auto& known = trajectory.points;
  const auto after = std::lower_bound(known.begin(), known.end(), stamp,
                                      [](const Trajectory::Point& p, Time t) { return p.stamp < t; });
  if (after != known.end() && after->stamp == stamp) {
    out = after->pose;
    return Lookup::found;
  }
  if (after == known.begin() || after == known.end()) return Lookup::outside;
  if (to_seconds(after->stamp - std::prev(after)->stamp) > max_time_gap_s) return Lookup::in_gap;
  out = interpolate(*std::prev(after), *after, stamp);
  return Lookup::found;
}

TrajectoryError score_trajectory(const Trajectory& estimate, const Trajectory& reference,
                                 const TrajectoryOptions& options) {
  const bool estimate_turns = estimate.orientation != Orientation::none;
  if (!options.lever_arm_m.isZero() && !estimate_turns) {
    throw Error(fmt::format("lever arm: {} has no orientation to turn it with", estimate.name));
  }
  const bool both_have_z = estimate.has_z && reference.has_z;
  if (options.align == Alignment::se3 && !both_have_z) {
    throw Error(fmt::format("alignment se3: {} has no z; use se2", estimate.has_z ? reference.name : estimate.name));
  }

  TrajectoryError out;
  out.reference_points = reference.points.size();
  std::vector<Pair> pairs = associate(estimate, reference, options.max_time_gap_s, out);
  out.scored = pairs.size();
  out.duration_s = to_seconds(pairs.back().stamp - pairs.front().stamp);
  out.dimensions = options.align != Alignment::se2 && both_have_z ? 3 : 2;
  out.align = options.align;

  const Pose lever{Eigen::Quaterniond::Identity(), options.lever_arm_m};
  for (Pair& pair : pairs) pair.estimate = pair.estimate * lever;
  out.T_reference_estimate = align(pairs, options.align);

  const bool both_turn = estimate_turns && reference.orientation != Orientation::none;
  const bool both_full = estimate.orientation == Orientation::full && reference.orientation == Orientation::full;
  std::vector<double> distances;
  std::vector<double> horizontal;
  std::vector<double> yaw_errors;
  for (Pair& pair : pairs) {
    pair.estimate = out.T_reference_estimate * pair.estimate;
    if (both_turn) yaw_errors.push_back(so3::wrap(pair.estimate.yaw() - pair.reference.yaw()));
    // Without all three angles on both sides roll and pitch would be compared with nothing.
    if (out.dimensions == 2) {
      pair.estimate = flattened(pair.estimate);
      pair.reference = flattened(pair.reference);
    } else if (both_turn && !both_full) {
      pair.estimate.q = so3::from_rpy(0.0, 0.0, pair.estimate.yaw());
      pair.reference.q = so3::from_rpy(0.0, 0.0, pair.reference.yaw());
    }
    const Eigen::Vector3d error = pair.estimate.p - pair.reference.p;
    distances.push_back(error.norm());
    horizontal.push_back(error.head<2>().norm());
  }
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    out.reference_length_m += (pairs[i].reference.p - pairs[i - 1].reference.p).norm();
  }
  out.position_m = statistics(std::move(distances));
  out.horizontal_m = statistics(std::move(horizontal));
  out.is_planar = out.dimensions == 3 && has_one_height(estimate);
  if (both_turn) out.yaw_rad = statistics(std::move(yaw_errors));
  out.relative = relative_error(pairs, options, both_turn);
  if (!both_turn) return out;
  if (out.is_planar) {
    for (Pair& pair : pairs) pair = {pair.stamp, flattened(pair.estimate), flattened(pair.reference)};
  }
  out.segments = score_segments(pairs);
  return out;
}

}  // namespace waymark::evaluation
