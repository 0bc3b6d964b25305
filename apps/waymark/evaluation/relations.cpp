// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/evaluation/relations.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "apps/waymark/evaluation/table.hpp"
#include "apps/waymark/evaluation/trajectory_error.hpp"
#include "waymark/base/error.hpp"

namespace waymark::evaluation {
namespace {

constexpr Duration kSameTime = std::chrono::microseconds(1);  // the digits of the files
constexpr int kRelationColumns = 8;

using PosePoints = std::vector<Trajectory::Point>;

PosePoints::const_iterator first_not_before(const PosePoints& points, Time stamp) {
  return std::lower_bound(points.begin(), points.end(), stamp,
                          [](const Trajectory::Point& point, Time t) { return point.stamp < t; });
}

/// The row of this time, to a microsecond, or none.
const Trajectory::Point* row_at(const Trajectory& trajectory, Time stamp) {
  const PosePoints& points = trajectory.points;
  const auto after = first_not_before(points, stamp);
  const Trajectory::Point* nearest = nullptr;
  const auto consider = [&](const Trajectory::Point& point) {
    const Duration distance = std::chrono::abs(point.stamp - stamp);
    if (distance <= kSameTime && (nearest == nullptr || distance < std::chrono::abs(nearest->stamp - stamp)))
      nearest = &point;
  };
  if (after != points.end()) consider(*after);
  if (after != points.begin()) consider(*std::prev(after));
  return nearest;
}

/// A trajectory without corrections, for what lies between the rows of another.
class Motion {
 public:
  Motion(const Trajectory& trajectory, double max_time_gap_s)
      : trajectory_(trajectory), max_time_gap_s_(max_time_gap_s) {
    constexpr double kMetresPerRadian = 0.5;  // a turn on the spot is a way, too
    way_.reserve(trajectory.points.size());
    double way = 0.0;
    for (std::size_t i = 0; i < trajectory.points.size(); ++i) {
      if (i > 0) {
        const Pose step = trajectory.points[i - 1].pose.inverse() * trajectory.points[i].pose;
        way += step.p.norm() + kMetresPerRadian * Eigen::AngleAxisd(step.q).angle();
      }
      way_.push_back(way);
    }
  }

  std::optional<Pose> pose(Time stamp) const {
    if (const Trajectory::Point* row = row_at(trajectory_, stamp)) return row->pose;
    Pose between;
    if (pose_at(trajectory_, stamp, max_time_gap_s_, between) == Lookup::found) return between;
    return std::nullopt;
  }

  /// The share of the way from `begin` to `end` that is done at `stamp`, 0 to 1; that of the time if there is no way.
  double share(Time begin, Time stamp, Time end) const {
    const double all = way_until(end) - way_until(begin);
    if (all > 1e-9) return std::clamp((way_until(stamp) - way_until(begin)) / all, 0.0, 1.0);
    return to_seconds(stamp - begin) / to_seconds(end - begin);
  }

 private:
  double way_until(Time stamp) const {
    const PosePoints& points = trajectory_.points;
    const auto after = first_not_before(points, stamp);
    if (after == points.begin()) return way_.front();
    if (after == points.end()) return way_.back();
    const auto i = static_cast<std::size_t>(after - points.begin());
    const double share = to_seconds(stamp - points[i - 1].stamp) / to_seconds(after->stamp - points[i - 1].stamp);
    return way_[i - 1] + share * (way_[i] - way_[i - 1]);
  }

  const Trajectory& trajectory_;
  double max_time_gap_s_;
  std::vector<double> way_;  // up to each row
};

Pose blend(const Pose& a, const Pose& b, double share) {
  return {a.q.slerp(share, b.q), (1.0 - share) * a.p + share * b.p};
}

/// The poses of an estimate at any time that it covers.
class Poses {
 public:
  Poses(const Trajectory& estimate, const std::optional<Motion>& motion, double max_time_gap_s)
      : estimate_(estimate), motion_(motion), max_time_gap_s_(max_time_gap_s) {}

  struct Found {
    Pose pose;
    bool at_row = false;
  };
  std::optional<Found> at(Time stamp) const {
    if (const Trajectory::Point* row = row_at(estimate_, stamp)) return Found{row->pose, true};
    if (motion_) return along_motion(stamp);
    Pose pose;
    if (pose_at(estimate_, stamp, max_time_gap_s_, pose) == Lookup::found) return Found{pose, false};
    return std::nullopt;
  }

 private:
  std::optional<Found> along_motion(Time stamp) const {
    const PosePoints& points = estimate_.points;
    const auto after = first_not_before(points, stamp);
    if (after == points.begin()) return moved(*after, stamp, true);
    if (after == points.end()) return moved(points.back(), stamp, true);
    const Trajectory::Point& before = *std::prev(after);
    const auto forward = moved(before, stamp, false);
    const auto back = moved(*after, stamp, false);
    if (!forward || !back) return std::nullopt;
    return Found{blend(forward->pose, back->pose, motion_->share(before.stamp, stamp, after->stamp)), false};
  }

  std::optional<Found> moved(const Trajectory::Point& row, Time stamp, bool beyond_the_ends) const {
    if (beyond_the_ends && std::abs(to_seconds(stamp - row.stamp)) > max_time_gap_s_) return std::nullopt;
    const auto begin = motion_->pose(row.stamp);
    const auto end = motion_->pose(stamp);
    if (!begin || !end) return std::nullopt;
    return Found{row.pose * (begin->inverse() * *end), false};
  }

  const Trajectory& estimate_;
  const std::optional<Motion>& motion_;
  double max_time_gap_s_;
};

Spread spread(const std::vector<double>& values) {
  Spread out;
  if (values.empty()) return out;
  const auto count = static_cast<double>(values.size());
  for (const double value : values) {
    out.mean += value / count;
    out.max = std::max(out.max, value);
  }
  double variance = 0.0;
  for (const double value : values) variance += (value - out.mean) * (value - out.mean) / count;
  out.deviation = std::sqrt(variance);
  return out;
}

/// Collects magnitudes of errors.
struct Errors {
  std::vector<double> translation;
  std::vector<double> rotation;

  void add(const Pose& error) {
    translation.push_back(error.p.norm());
    rotation.push_back(2.0 * std::atan2(error.q.vec().norm(), std::abs(error.q.w())));
  }
  RelationErrors summary() const {
    const auto squares = [](std::vector<double> values) {
      for (double& value : values) value *= value;
      return values;
    };
    return {translation.size(), spread(translation), spread(squares(translation)), spread(rotation),
            spread(squares(rotation))};
  }
};

void needs_orientation(const Trajectory& trajectory) {
  if (trajectory.orientation == Orientation::none)
    throw Error(fmt::format("relations: {} has no orientation", trajectory.name));
}

}  // namespace

std::vector<Relation> read_relations(const std::filesystem::path& file) {
  const Table table(file);
  std::vector<Relation> relations;
  relations.reserve(table.rows());
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const auto number = [&](int column, const char* name) { return table.number(row, column, name); };
    const double yaw = number(kRelationColumns - 1, "yaw");  // the last one first: it shows a line that is too short
    Relation relation{table.time(row, 0, "t1"), table.time(row, 1, "t2"), {}};
    relation.T_from_to.p = {number(2, "x"), number(3, "y"), number(4, "z")};
    relation.T_from_to.q = so3::from_rpy(number(5, "roll"), number(6, "pitch"), yaw);
    relations.push_back(relation);
  }
  return relations;
}

RelationScore score_relations(const std::vector<Relation>& relations, const Trajectory& estimate,
                              const std::optional<Trajectory>& motion, const RelationOptions& options) {
  needs_orientation(estimate);
  std::optional<Motion> between;
  if (motion) {
    needs_orientation(*motion);
    between.emplace(*motion, options.max_time_gap_s);
  }
  const Poses poses(estimate, between, options.max_time_gap_s);
  RelationScore score;
  score.relations = relations.size();
  Errors all;
  Errors far_apart;
  for (const Relation& relation : relations) {
    const auto from = poses.at(relation.from);
    const auto to = poses.at(relation.to);
    if (!from || !to) {
      ++score.uncovered;
      continue;
    }
    score.poses += 2;
    score.poses_at_row += (from->at_row ? 1U : 0U) + (to->at_row ? 1U : 0U);
    const Pose moved = (from->pose * options.T_base_sensor).inverse() * (to->pose * options.T_base_sensor);
    const Pose error = relation.T_from_to.inverse() * moved;
    all.add(error);
    if (std::chrono::abs(relation.to - relation.from) > from_seconds(options.far_apart_s)) far_apart.add(error);
  }
  if (all.translation.empty())
    throw Error(fmt::format("relations: none of {} is covered by {}; are the clocks the same?", relations.size(),
                            estimate.name));
  score.all = all.summary();
  score.far_apart = far_apart.summary();
  return score;
}

}  // namespace waymark::evaluation
