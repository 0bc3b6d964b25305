// SPDX-License-Identifier: Apache-2.0
#include "yaw_column.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include "field_columns.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::csv {
namespace {

constexpr FieldInfo kQuaternion{.names = {"q_w", "q_x", "q_y", "q_z"},
                                .meaning = "instead of `yaw_rad`: the attitude as a quaternion",
                                .required = false};

}  // namespace

std::vector<FieldName> YawColumn::fields() {
  std::vector<FieldName> fields{{"yaw_rad", "rad"}};
  for (const std::string_view name : kQuaternion.names) fields.push_back({name, ""});
  return fields;
}

std::optional<YawColumn> YawColumn::find(const Config& columns, const Config::Key& yaw, std::string_view owner,
                                         ColumnFinder& finder) {
  YawColumn found;
  found.columns_ = all_or_none(columns, kQuaternion, owner, finder);
  if (auto column = optional_number_column(columns, yaw, finder)) {
    if (!found.columns_.empty()) columns.fail("q_w", "give either the yaw or the quaternion");
    found.columns_.push_back(std::move(*column));
  }
  return found.columns_.empty() ? std::nullopt : std::optional(std::move(found));
}

double YawColumn::read(Row row) const {
  if (columns_.size() == 1) return columns_.front().read(row);
  const auto q = read_quaternion(row, columns_, kQuaternion);
  return q ? so3::yaw(*q) : std::numeric_limits<double>::quiet_NaN();
}

std::optional<Eigen::Quaterniond> YawColumn::read_attitude(Row row) const {
  if (columns_.size() != 1) return read_quaternion(row, columns_, kQuaternion);
  const double yaw = columns_.front().read(row);
  return std::isnan(yaw) ? std::nullopt : std::optional(so3::from_rpy(0.0, 0.0, yaw));
}

}  // namespace waymark::csv
