// SPDX-License-Identifier: Apache-2.0
#include "reference.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include "bad_row.hpp"
#include "column_map.hpp"
#include "delimited_reader.hpp"
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

std::vector<Reference::Point> read_trajectory(const Config& config) {
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
  std::vector<FieldName> fields{{"time", "s"}, {"x_m", "m"}, {"y_m", "m"}};
  for (const FieldName& field : YawColumn::fields()) fields.push_back(field);
  check_fields(columns, fields, {"time", "x_m", "y_m"}, "the reference trajectory");
  const TimeColumn time(
      columns, {"time", "s", "a column in seconds or of dates, or `{ column, unit or scale, offset_s }`"}, finder);
  const NumberColumn x(columns, {"x_m", "m", "position of the base in the map"}, finder);
  const NumberColumn y(columns, {"y_m", "m", "position of the base in the map"}, finder);
  const auto yaw = YawColumn::find(columns, {"yaw_rad", "rad", "yaw of the base in the map", "none"},
                                   "the reference trajectory", finder);
  config.reject_unread();

  std::vector<Reference::Point> points;
  for_each_row(reader, finder, filter, [&](Row row) {
    Reference::Point point;
    point.stamp = time.read(row);
    if (!points.empty() && point.stamp < points.back().stamp) {
      throw BadRow("time goes back, from " + format_time(points.back().stamp) + " to " + format_time(point.stamp));
    }
    if (!points.empty() && point.stamp - points.back().stamp < min_step) return;
    const double yaw_rad = yaw ? yaw->read(row) : std::numeric_limits<double>::quiet_NaN();
    point.has_yaw = !std::isnan(yaw_rad);
    point.T_map_base = Pose::planar(x.read(row), y.read(row), point.has_yaw ? yaw_rad : 0.0);
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

std::shared_ptr<const Reference> read_reference(const Config& config) {
  auto reference = std::make_shared<Reference>();
  if (config.has("trajectory")) reference->trajectory = read_trajectory(config.child({"trajectory", "the true poses"}));
  if (config.has("landmarks")) reference->landmarks = read_landmarks(config.child({"landmarks", "the true landmarks"}));
  config.reject_unread();
  return reference;
}

}  // namespace waymark::csv
