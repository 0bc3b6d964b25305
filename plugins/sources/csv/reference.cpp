// SPDX-License-Identifier: Apache-2.0
#include "reference.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include "bad_row.hpp"
#include "column_map.hpp"
#include "delimited_reader.hpp"
#include "number_text.hpp"
#include "row_filter.hpp"
#include "time_column.hpp"
#include "yaw_column.hpp"

namespace waymark::csv {
namespace {

/// Calls `use(row)` for every row that `where` keeps; a bad row is an error, as a score against half a truth means
/// nothing.
template <class Use>
void for_each_row(DelimitedReader& reader, const ColumnFinder& finder, const RowFilter& filter, Use use) {
  while (reader.next()) {
    try {
      const Row row = reader.row();
      if (row.size() < finder.needed_fields()) {
        throw BadRow("too few columns: " + std::to_string(row.size()) + ", at least " +
                     std::to_string(finder.needed_fields()) + " are expected");
      }
      if (filter.keeps(row)) use(row);
    } catch (const BadRow& bad) {
      throw DataError(reader.place() + ": " + bad.what());
    }
  }
}

/// Where the sensor is mounted whose poses a trajectory has.
std::optional<Pose> mounting_of(const Config& config, const Rig& rig) {
  if (!config.has("sensor")) return std::nullopt;
  const std::string name = config.text(
      {"sensor", "", "the poses are those of this sensor, and `base_T_sensor` makes poses of the base of them",
       "they are those of the base"});
  if (rig.find(name) < 0) config.fail("sensor", "there is no sensor " + in_quotes(name) + " under sensors");
  return rig.T_base_sensor(name);
}

std::vector<Reference::Point> read_trajectory(const Config& config, const Rig& rig) {
  DelimitedReader reader(text_file(config), read_format(config));
  ColumnFinder finder(reader.header());
  if (empty_is_unknown(config)) finder.allow_empty();
  const RowFilter filter(config, finder);
  const Duration min_step = from_seconds(config.non_negative({"min_step_s", "s",
                                                              "thins it out: a pose that lies less than this after the "
                                                              "last one taken is passed over, such as a burst of poses "
                                                              "that a computer stamped when it had time"},
                                                             0.0));
  const Config columns =
      config.child({"columns", "which column goes to which field: a column, or `{ column, scale, offset }`"});
  std::vector<FieldName> fields{{"time", "s"}, {"x_m", "m"}, {"y_m", "m"}, {"z_m", "m"}};
  for (const FieldName& field : YawColumn::fields()) fields.push_back(field);
  check_fields(columns, fields, {"time", "x_m", "y_m"}, "the reference trajectory");
  const TimeColumn time(
      columns, {"time", "s", "a column in seconds or of dates, or `{ column, unit or scale, offset_s }`"}, finder);
  const NumberColumn x(columns, {"x_m", "m", "position of the base in the map"}, finder);
  const NumberColumn y(columns, {"y_m", "m", "position of the base in the map"}, finder);
  const auto z = optional_number_column(
      columns,
      {"z_m", "m", "height of the base in the map; with it a quaternion's roll and pitch count, too", "a planar pose"},
      finder);
  const auto yaw = YawColumn::find(columns, {"yaw_rad", "rad", "yaw of the base in the map", "none"},
                                   "the reference trajectory", finder);
  const std::optional<Pose> T_base_sensor = mounting_of(config, rig);
  if (T_base_sensor && !yaw) config.fail("sensor", "needs the attitude, as yaw_rad or as a quaternion, under columns");
  config.reject_unread();

  std::vector<Reference::Point> points;
  for_each_row(reader, finder, filter, [&](Row row) {
    Reference::Point point;
    point.stamp = time.read(row);
    if (!points.empty() && point.stamp < points.back().stamp) {
      throw BadRow("time goes back, from " + format_time(points.back().stamp) + " to " + format_time(point.stamp));
    }
    if (!points.empty() && point.stamp - points.back().stamp < min_step) return;
    if (z || T_base_sensor) {
      const auto q = yaw ? yaw->read_attitude(row) : std::nullopt;
      point.has_yaw = q.has_value();
      if (T_base_sensor && !q) return;  // nothing says where the base is then
      point.T_map_base = {q.value_or(Eigen::Quaterniond::Identity()),
                          {x.read(row), y.read(row), z ? z->read(row) : 0.0}};
      if (!point.T_map_base.p.allFinite()) throw BadRow("a position is expected, and a part of it is empty");
      if (T_base_sensor) point.T_map_base = point.T_map_base * T_base_sensor->inverse();
      if (!z) {
        const Pose& T = point.T_map_base;
        point.T_map_base = Pose::planar(T.p.x(), T.p.y(), T.yaw());
      }
    } else {
      const double yaw_rad = yaw ? yaw->read(row) : std::numeric_limits<double>::quiet_NaN();
      point.has_yaw = !std::isnan(yaw_rad);
      point.T_map_base = Pose::planar(x.read(row), y.read(row), point.has_yaw ? yaw_rad : 0.0);
    }
    point.is_planar = !z;
    points.push_back(point);
  });
  return points;
}

std::vector<Reference::Landmark> read_landmarks(const Config& config) {
  DelimitedReader reader(text_file(config), read_format(config));
  ColumnFinder finder(reader.header());
  if (empty_is_unknown(config)) finder.allow_empty();
  const RowFilter filter(config, finder);
  const Config columns =
      config.child({"columns", "which column goes to which field: a column, or `{ column, scale, offset }`"});
  check_fields(columns, {{"name", ""}, {"x_m", "m"}, {"y_m", "m"}, {"radius_m", "m"}}, {"x_m", "y_m"},
               "the reference landmarks");
  std::optional<Column> name;
  if (columns.has("name"))
    name = finder.find(columns, {"name", "", "name of the landmark", "number of the row, from 0"}, "name");
  const NumberColumn x(columns, {"x_m", "m", "position of the centre in the map"}, finder);
  const NumberColumn y(columns, {"y_m", "m", "position of the centre in the map"}, finder);
  const auto radius = optional_number_column(columns, {"radius_m", "m", "radius of the landmark", "unknown"}, finder);
  config.reject_unread();

  std::vector<Reference::Landmark> landmarks;
  for_each_row(reader, finder, filter, [&](Row row) {
    Reference::Landmark landmark;
    landmark.name = name ? std::string(row[name->index]) : std::to_string(landmarks.size());
    landmark.p_map = {x.read(row), y.read(row)};
    landmark.radius_m = radius ? radius->read(row) : std::numeric_limits<double>::quiet_NaN();
    landmarks.push_back(std::move(landmark));
  });
  return landmarks;
}

}  // namespace

std::shared_ptr<const Reference> read_reference(const Config& config, const Rig& rig) {
  auto reference = std::make_shared<Reference>();
  if (config.has("trajectory"))
    reference->trajectory = read_trajectory(config.child({"trajectory", "the true poses"}), rig);
  if (config.has("landmarks")) reference->landmarks = read_landmarks(config.child({"landmarks", "the true landmarks"}));
  config.reject_unread();
  return reference;
}

}  // namespace waymark::csv
