// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "waymark/base/time.hpp"
#include "waymark/interface/sensor.hpp"

namespace waymark::geo_track {

/// A place on the Earth (WGS-84).
struct Place {
  double latitude_deg = 0.0;
  double longitude_deg = 0.0;
  double height_m = 0.0;  ///< above the ellipsoid
};

struct TrackPoint {
  Time stamp;
  Place place;
};

/// A landmark of the map.
struct Mark {
  std::string name;
  Place place;
};

/// What the formats show: the path in pieces, each without an interruption, and the landmarks.
struct Track {
  std::string name;
  std::vector<std::vector<TrackPoint>> pieces;
  std::vector<Mark> marks;
};

/// The path in the map, thinned. Memory is bounded: beyond `kMostPoints` every second point is dropped and the interval
/// doubled, so that the choice depends on the data only.
class ThinnedPath {
 public:
  struct Point {
    Time stamp;
    Eigen::Vector3d p_map;
    bool begins_piece = false;
  };
  static constexpr std::size_t kMostPoints = 200'000;

  explicit ThinnedPath(Duration every, std::size_t most = kMostPoints) : every_(every), most_(most) {}
  void add(Time stamp, const Eigen::Vector3d& p_map);
  /// The next point begins another piece.
  void interrupt() { is_interrupted_ = true; }
  /// The points on the Earth.
  std::vector<std::vector<TrackPoint>> pieces(const Datum& datum) const;

 private:
  Duration every_;
  std::size_t most_;
  std::vector<Point> points_;
  bool is_interrupted_ = true;
};

/// Points of the map on the Earth.
std::vector<Place> places(const std::vector<Eigen::Vector3d>& points, const Datum& datum);

/// UTC with milliseconds, "2024-05-01T12:00:00.000Z".
std::string iso_time(Time stamp);

/// The formats. Coordinates have eight decimals (1 mm).
std::string to_gpx(const Track& track);      ///< GPX 1.1, times included
std::string to_kml(const Track& track);      ///< KML 2.2
std::string to_geojson(const Track& track);  ///< RFC 7946

}  // namespace waymark::geo_track
