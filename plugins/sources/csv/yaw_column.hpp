// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string_view>
#include <vector>

#include "column_map.hpp"

namespace waymark::csv {

/// The yaw of a pose: a column, or what a quaternion in four columns turns about the z axis.
class YawColumn {
 public:
  /// The fields that a yaw may be read from.
  static std::vector<FieldName> fields();

  /// `owner` is what messages call the pose. Nothing if there are no such columns. Throws ConfigError for both, and for
  /// a part of a quaternion.
  static std::optional<YawColumn> find(const Config& columns, const Config::Key& yaw, std::string_view owner,
                                       ColumnFinder& finder);

  /// NaN if it is unknown. Throws BadRow for what is no number and no unit quaternion.
  double read(Row row) const;
  /// The whole attitude; level if there is a yaw only. Nothing if it is unknown.
  std::optional<Eigen::Quaterniond> read_attitude(Row row) const;

 private:
  std::vector<NumberColumn> columns_;  // yaw; or w, x, y, z
};

}  // namespace waymark::csv
