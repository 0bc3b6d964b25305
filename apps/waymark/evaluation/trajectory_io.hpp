// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "apps/waymark/evaluation/table.hpp"
#include "waymark/base/time.hpp"
#include "waymark/interface/sensor.hpp"
#include "waymark/math/pose.hpp"

namespace waymark::evaluation {

/// How much of the orientation a file holds.
enum class Orientation { none, yaw, full };

/// Poses in order of their stamps, no stamp twice.
struct Trajectory {
  struct Point {
    Time stamp;
    Pose pose;  ///< in the map frame; parts that are not known are zero
  };
  std::string name;  ///< the file, for messages
  bool has_z = false;
  Orientation orientation = Orientation::none;
  std::vector<Point> points;
};

/// A landmark of a map file or of a survey.
struct Landmark {
  std::string name;
  Eigen::Vector2d p_map = Eigen::Vector2d::Zero();             ///< east, north [m]
  double radius_m = std::numeric_limits<double>::quiet_NaN();  ///< NaN: unknown
  int sightings = std::numeric_limits<int>::max();             ///< the largest number where a file does not count them
  std::optional<Eigen::Matrix2d> P = std::nullopt;             ///< of east and north [m²], where a file has it
};

/// Quantities that `--columns` may name: t, x, y, z, yaw, qx, qy, qz, qw.
const std::vector<std::string>& trajectory_quantities();
/// Quantities that `--survey-columns` may name: name, x, y, radius.
const std::vector<std::string>& survey_quantities();

/// Reads a trajectory: with `columns` those columns; else by the names in the first row (t, t_s, time; x, x_m, east_m;
/// y, y_m, north_m; z, z_m, up_m; yaw, yaw_rad; qx … qw); else eight blank-separated columns are TUM (t x y z qx qy qz
/// qw). Seconds, metres, radians. z counts only if every row has one, and where one has NaN in its place, of
/// quaternions only the yaw; a file whose quaternions are all exactly the identity has no orientation (that is how
/// "unknown" is written). Rows are sorted by stamp; of equal stamps the last row stays. Where x is empty or absent,
/// latitude_deg, longitude_deg and height_m count, with `datum` as the origin. Throws DataError with file and line.
Trajectory read_trajectory(const std::filesystem::path& file, const std::optional<Columns>& columns = std::nullopt,
                           const std::optional<Datum>& datum = std::nullopt);

/// Reads landmarks by the names in the first row (id, name; x, x_m, east_m; y, y_m, north_m; radius, radius_m;
/// sightings) or by `columns`. Throws DataError with file and line.
std::vector<Landmark> read_landmarks(const std::filesystem::path& file,
                                     const std::optional<Columns>& columns = std::nullopt);

}  // namespace waymark::evaluation
