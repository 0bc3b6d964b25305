// SPDX-License-Identifier: Apache-2.0
#include "motion_builder.hpp"

#include <cmath>
#include <numbers>

#include "bad_row.hpp"
#include "waymark/math/pose_increment.hpp"

namespace waymark::csv {
namespace {

/// What a row holds: two ways, or x, y and yaw.
struct MotionTotals : PayloadOf<MotionTotals> {
  static constexpr std::string_view kType = "csv/MotionTotals@1";
  Eigen::Vector3d values = Eigen::Vector3d::Zero();
};

/// Along an arc.
PoseIncrement by_wheels(double left_m, double right_m, double track_m, double interval_s) {
  PoseIncrement motion;
  motion.interval_s = interval_s;
  motion.yaw_rad = (right_m - left_m) / track_m;
  const double way = 0.5 * (left_m + right_m);
  const double half = 0.5 * motion.yaw_rad;
  const double chord = std::abs(half) < 1e-6 ? way : way * std::sin(half) / half;
  motion.x_m = chord * std::cos(half);
  motion.y_m = chord * std::sin(half);
  return motion;
}

}  // namespace

MotionBuilder::MotionBuilder(const Config& entry, const Config& columns, ColumnFinder& finder) {
  using Keys = std::vector<Config::Key>;
  constexpr std::string_view kOwner = "PoseIncrement out of totals";
  const bool by_wheels = columns.has("left_m") || columns.has("right_m") || given_key(columns, {"left_m", "m"}) ||
                         given_key(columns, {"right_m", "m"});
  const Keys keys =
      by_wheels ? Keys{{"left_m", "m", "way of the left wheel since the start; `scale` makes metres of ticks"},
                       {"right_m", "m", "way of the right wheel since the start"}}
                : Keys{{"x_m", "m", "where odometry has the robot"}, {"y_m", "m", "where odometry has the robot"}};
  if (by_wheels) {
    track_m_ =
        entry.positive({"track_m", "m", "of totals of two wheels as `PoseIncrement`: the distance between them"});
  }
  std::vector<FieldName> fields;
  std::vector<std::string_view> names;
  for (const Config::Key& key : keys) {
    fields.push_back({key.name, key.unit});
    names.push_back(key.name);
  }
  if (!by_wheels) {
    for (const FieldName& field : YawColumn::fields()) fields.push_back(field);
    if (!given_key(columns, {"q_w", ""})) names.emplace_back("yaw_rad");
  }
  check_fields(columns, fields, names, kOwner);
  for (const Config::Key& key : keys) columns_.emplace_back(columns, key, finder);
  if (by_wheels) return;
  yaw_ = YawColumn::find(columns, {"yaw_rad", "rad", "where odometry has the robot"}, kOwner, finder);
  if (entry.is_mapping("cumulative")) entry.fail("cumulative", "poses do not start over, ticks do; true is expected");
}

std::shared_ptr<Payload> MotionBuilder::build(Row row) const {
  auto totals = std::make_shared<MotionTotals>();
  for (std::size_t i = 0; i < columns_.size(); ++i)
    totals->values[static_cast<Eigen::Index>(i)] = columns_[i].read(row);
  if (yaw_) {
    totals->values[2] = yaw_->read(row);
    if (std::isnan(totals->values[2])) throw BadRow("the attitude is unknown: a quaternion of zeros");
  }
  return totals;
}

std::shared_ptr<Payload> MotionBuilder::growth(const Payload& before, const Payload& after, double seconds,
                                               double wraps_at) const {
  const auto& first = static_cast<const MotionTotals&>(before).values;
  const auto& last = static_cast<const MotionTotals&>(after).values;
  auto motion = std::make_shared<PoseIncrement>(
      track_m_ > 0.0 ? by_wheels(columns_[0].growth(first[0], last[0], wraps_at),
                                 columns_[1].growth(first[1], last[1], wraps_at), track_m_, seconds)
                     : pose_increment(first, last, seconds));
  if (!(std::abs(motion->yaw_rad) < std::numbers::pi)) {
    throw BadRow("the wheels turned the robot by half a turn or more since the row before");
  }
  return motion;
}

}  // namespace waymark::csv
