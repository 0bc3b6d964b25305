// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "payload_builders.hpp"
#include "yaw_column.hpp"

namespace waymark::csv {

/// Motions out of totals: the ways of two wheels since the start (ticks of encoders), or the pose where odometry has
/// the robot. Each row gives how far the base moved since the row before.
class MotionBuilder final : public PayloadBuilder {
 public:
  /// Columns `left_m` and `right_m`, with `track_m` of the entry; or `x_m`, `y_m` and `yaw_rad`
  /// or a quaternion. Throws ConfigError.
  MotionBuilder(const Config& entry, const Config& columns, ColumnFinder& finder);

  std::shared_ptr<Payload> build(Row row) const override;
  /// Throws BadRow for half a turn or more: wheels do not turn a robot so far from one row to the next.
  std::shared_ptr<Payload> growth(const Payload& before, const Payload& after, double seconds,
                                  double wraps_at) const override;
  Totals totals() const override { return Totals::motion; }

 private:
  std::vector<NumberColumn> columns_;  // left, right; or x, y
  std::optional<YawColumn> yaw_;       // of a pose
  double track_m_ = 0.0;               // 0: the columns hold a pose
};

}  // namespace waymark::csv
