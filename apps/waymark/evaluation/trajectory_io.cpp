// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/evaluation/trajectory_io.hpp"

#include <fmt/format.h>

#include <GeographicLib/LocalCartesian.hpp>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "waymark/base/error.hpp"

namespace waymark::evaluation {
namespace {

struct Alias {
  std::string_view quantity;
  std::vector<std::string_view> names;  // the first one found in a file counts
};

const std::vector<Alias>& trajectory_aliases() {
  static const std::vector<Alias> aliases{
      {"t", {"t", "t_s", "time", "time_s", "timestamp", "timestamp_s"}},
      {"x", {"x", "x_m", "east_m", "tx"}},
      {"y", {"y", "y_m", "north_m", "ty"}},
      {"z", {"z", "z_m", "up_m", "tz"}},
      {"yaw", {"yaw", "yaw_rad"}},
      {"qx", {"qx"}},
      {"qy", {"qy"}},
      {"qz", {"qz"}},
      {"qw", {"qw"}},
      {"latitude", {"latitude_deg"}},
      {"longitude", {"longitude_deg"}},
      {"height", {"height_m"}},
  };
  return aliases;
}

const std::vector<Alias>& landmark_aliases() {
  static const std::vector<Alias> aliases{
      {"name", {"name", "id"}},           {"x", {"x", "x_m", "east_m"}},     {"y", {"y", "y_m", "north_m"}},
      {"radius", {"radius", "radius_m"}}, {"sightings", {"sightings"}},      {"var_x", {"var_east_m2"}},
      {"var_y", {"var_north_m2"}},        {"cov_xy", {"cov_east_north_m2"}},
  };
  return aliases;
}

std::vector<std::string_view> all_names(const std::vector<Alias>& aliases) {
  std::vector<std::string_view> names;
  for (const Alias& alias : aliases) names.insert(names.end(), alias.names.begin(), alias.names.end());
  return names;
}

Columns columns_by_name(const Table& table, const std::vector<Alias>& aliases) {
  Columns columns;
  for (const Alias& alias : aliases) {
    for (const std::string_view name : alias.names) {
      for (int i = 0; i < table.width(); ++i) {
        if (table.field(0, i) == name) columns.emplace(alias.quantity, i);
      }
    }
  }
  return columns;
}

int column_or_none(const Columns& columns, std::string_view quantity) {
  const auto found = columns.find(quantity);
  return found == columns.end() ? -1 : found->second;
}

int column(const Table& table, const Columns& columns, std::string_view quantity, const std::vector<Alias>& aliases) {
  const int index = column_or_none(columns, quantity);
  if (index >= 0) return index;
  const auto alias =
      std::find_if(aliases.begin(), aliases.end(), [&](const Alias& a) { return a.quantity == quantity; });
  throw DataError(fmt::format("{}: no column for {} (a name in the first row: {}; or give the columns)",
                              table.file().string(), quantity, fmt::join(alias->names, ", ")));
}

// Determines the columns and removes the row of names, if there is one.
Columns determine_columns(Table& table, const std::vector<Alias>& aliases, const std::optional<Columns>& given) {
  const bool named = table.starts_with_names(all_names(aliases));
  Columns columns;
  if (given) {
    columns = *given;
  } else if (named) {
    columns = columns_by_name(table, aliases);
  }
  if (named) table.drop_first_row();
  return columns;
}

Eigen::Quaterniond read_quaternion(const Table& table, std::size_t row, int x, int y, int z, int w) {
  const Eigen::Quaterniond q(table.number(row, w, "qw"), table.number(row, x, "qx"), table.number(row, y, "qy"),
                             table.number(row, z, "qz"));
  // Files are written with few digits, so the length is checked loosely and then made one.
  if (std::abs(q.norm() - 1.0) > 0.01) {
    throw DataError(fmt::format("{}: quaternion of length {:.6g}, expected 1", table.place(row), q.norm()));
  }
  return q.normalized();
}

int read_count(const Table& table, std::size_t row, int column, std::string_view name) {
  const double count = table.number(row, column, name);
  if (!(count >= 0.0 && count <= std::numeric_limits<int>::max()))
    throw DataError(fmt::format("{}: {} is \"{}\", expected a number from 0 to {}", table.place(row), name,
                                table.field(row, column), std::numeric_limits<int>::max()));
  return static_cast<int>(count);
}

void sort_by_stamp(std::vector<Trajectory::Point>& points) {
  std::stable_sort(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.stamp < b.stamp; });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (kept > 0 && points[kept - 1].stamp == points[i].stamp) --kept;
    points[kept++] = points[i];
  }
  points.resize(kept);
}

/// Columns of a file that hold geodetic coordinates.
class GeodeticColumns {
 public:
  GeodeticColumns(const Columns& columns, const std::optional<Datum>& datum)
      : latitude_(column_or_none(columns, "latitude")),
        longitude_(column_or_none(columns, "longitude")),
        height_(column_or_none(columns, "height")),
        datum_(datum) {
    if (datum) frame_.Reset(datum->latitude_deg, datum->longitude_deg, datum->height_m);
  }

  bool given() const { return latitude_ >= 0 && longitude_ >= 0; }
  bool has_height() const { return given() && height_ >= 0; }

  /// East, north, up [m]; up is NaN if there is no height. Throws DataError.
  Eigen::Vector3d position(const Table& table, std::size_t row) const {
    const double latitude = table.number(row, latitude_, "latitude");
    const double longitude = table.number(row, longitude_, "longitude");
    if (!datum_) {
      throw DataError(
          fmt::format("{}: the positions are geodetic; --datum must give the map's origin", table.place(row)));
    }
    const double height = height_ >= 0 ? table.number_or_nan(row, height_) : std::numeric_limits<double>::quiet_NaN();
    Eigen::Vector3d p;
    frame_.Forward(latitude, longitude, std::isnan(height) ? datum_->height_m : height, p.x(), p.y(), p.z());
    if (!p.allFinite()) {
      throw DataError(fmt::format("{}: latitude {}°, longitude {}°, height {} m is not a place on the Earth",
                                  table.place(row), latitude, longitude, height));
    }
    if (std::isnan(height)) p.z() = height;
    return p;
  }

 private:
  int latitude_;
  int longitude_;
  int height_;
  std::optional<Datum> datum_;
  GeographicLib::LocalCartesian frame_;
};

}  // namespace

const std::vector<std::string>& trajectory_quantities() {
  static const std::vector<std::string> names{"t", "x", "y", "z", "yaw", "qx", "qy", "qz", "qw"};
  return names;
}

const std::vector<std::string>& survey_quantities() {
  static const std::vector<std::string> names{"name", "x", "y", "radius"};
  return names;
}

Trajectory read_trajectory(const std::filesystem::path& file, const std::optional<Columns>& given,
                           const std::optional<Datum>& datum) {
  Table table(file);
  const auto& aliases = trajectory_aliases();
  Columns columns = determine_columns(table, aliases, given);
  if (columns.empty() && table.blank_separated() && table.width() == 8) {
    columns = {{"t", 0}, {"x", 1}, {"y", 2}, {"z", 3}, {"qx", 4}, {"qy", 5}, {"qz", 6}, {"qw", 7}};
  }
  const int t = column(table, columns, "t", aliases);
  const GeodeticColumns geodetic(columns, datum);
  const int x = geodetic.given() ? column_or_none(columns, "x") : column(table, columns, "x", aliases);
  const int y = geodetic.given() ? column_or_none(columns, "y") : column(table, columns, "y", aliases);
  const int z = column_or_none(columns, "z");
  const int yaw = column_or_none(columns, "yaw");
  const int qx = column_or_none(columns, "qx");
  const int qy = column_or_none(columns, "qy");
  const int qz = column_or_none(columns, "qz");
  const int qw = column_or_none(columns, "qw");
  const bool quaternion = qx >= 0 && qy >= 0 && qz >= 0 && qw >= 0;

  Trajectory out;
  out.name = file.string();
  out.has_z = z >= 0 || geodetic.has_height();
  bool turned = false;
  bool lacks_height = false;  // and so roll and pitch, too
  for (std::size_t row = 0; row < table.rows(); ++row) {
    Pose pose;
    if (geodetic.given() && (x < 0 || y < 0 || std::isnan(table.number_or_nan(row, x)))) {
      pose.p = geodetic.position(table, row);
    } else {
      pose.p = {table.number(row, x, "x"), table.number(row, y, "y"), z >= 0 ? table.number_or_nan(row, z) : 0.0};
    }
    if (std::isnan(pose.p.z())) out.has_z = false;
    lacks_height = lacks_height || std::isnan(pose.p.z());
    if (quaternion) {
      pose.q = read_quaternion(table, row, qx, qy, qz, qw);
      turned = turned || pose.q.vec() != Eigen::Vector3d::Zero();
    } else if (yaw >= 0) {
      pose.q = so3::from_rpy(0.0, 0.0, table.number(row, yaw, "yaw"));
    }
    out.points.push_back({table.time(row, t), pose});
  }
  if (!out.has_z) {
    for (auto& point : out.points) point.pose.p.z() = 0.0;
  }
  if (quaternion) {
    out.orientation = !turned ? Orientation::none : lacks_height ? Orientation::yaw : Orientation::full;
  } else {
    out.orientation = yaw >= 0 ? Orientation::yaw : Orientation::none;
  }
  sort_by_stamp(out.points);
  return out;
}

std::vector<Landmark> read_landmarks(const std::filesystem::path& file, const std::optional<Columns>& given) {
  Table table(file);
  const auto& aliases = landmark_aliases();
  const Columns columns = determine_columns(table, aliases, given);
  const int x = column(table, columns, "x", aliases);
  const int y = column(table, columns, "y", aliases);
  const int name = column_or_none(columns, "name");
  const int radius = column_or_none(columns, "radius");
  const int sightings = column_or_none(columns, "sightings");
  const int var_x = column_or_none(columns, "var_x");
  const int var_y = column_or_none(columns, "var_y");
  const int cov_xy = column_or_none(columns, "cov_xy");

  std::vector<Landmark> out;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    Landmark landmark;
    landmark.name = name >= 0 ? table.field(row, name) : fmt::format("{}", row + 1);
    landmark.p_map = {table.number(row, x, "x"), table.number(row, y, "y")};
    if (radius >= 0) landmark.radius_m = table.number_or_nan(row, radius);
    if (sightings >= 0) landmark.sightings = read_count(table, row, sightings, "sightings");
    if (var_x >= 0 && var_y >= 0 && cov_xy >= 0) {
      Eigen::Matrix2d P;
      P << table.number_or_nan(row, var_x), table.number_or_nan(row, cov_xy), 0.0, table.number_or_nan(row, var_y);
      P(1, 0) = P(0, 1);
      if (P(0, 0) > 0.0 && P.determinant() > 0.0) landmark.P = P;
    }
    out.push_back(std::move(landmark));
  }
  return out;
}

}  // namespace waymark::evaluation
