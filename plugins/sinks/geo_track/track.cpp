// SPDX-License-Identifier: Apache-2.0
#include "track.hpp"

#include <fmt/format.h>

#include <GeographicLib/LocalCartesian.hpp>
#include <chrono>
#include <ctime>

namespace waymark::geo_track {

void ThinnedPath::add(Time stamp, const Eigen::Vector3d& p_map) {
  if (!is_interrupted_ && stamp - points_.back().stamp < every_) return;
  points_.push_back({stamp, p_map, is_interrupted_});
  is_interrupted_ = false;
  if (points_.size() < most_) return;
  std::vector<Point> kept;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (i % 2 == 0 || points_[i].begins_piece) kept.push_back(points_[i]);
  }
  points_ = std::move(kept);
  every_ = std::max<Duration>(2 * every_, Duration{1'000'000});
}

std::vector<std::vector<TrackPoint>> ThinnedPath::pieces(const Datum& datum) const {
  std::vector<Eigen::Vector3d> positions;
  positions.reserve(points_.size());
  for (const Point& point : points_) positions.push_back(point.p_map);
  const std::vector<Place> on_earth = places(positions, datum);
  std::vector<std::vector<TrackPoint>> result;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (points_[i].begins_piece) result.emplace_back();
    result.back().push_back({points_[i].stamp, on_earth[i]});
  }
  return result;
}

std::vector<Place> places(const std::vector<Eigen::Vector3d>& points, const Datum& datum) {
  const GeographicLib::LocalCartesian frame(datum.latitude_deg, datum.longitude_deg, datum.height_m);
  std::vector<Place> result(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    Place& place = result[i];
    frame.Reverse(points[i].x(), points[i].y(), points[i].z(), place.latitude_deg, place.longitude_deg, place.height_m);
  }
  return result;
}

std::string iso_time(Time stamp) {
  const auto ms = std::chrono::floor<std::chrono::milliseconds>(stamp.time_since_epoch()).count();
  const std::int64_t fraction = ((ms % 1000) + 1000) % 1000;
  const std::time_t seconds = static_cast<std::time_t>((ms - fraction) / 1000);
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:03}Z", utc.tm_year + 1900, utc.tm_mon + 1, utc.tm_mday,
                     utc.tm_hour, utc.tm_min, utc.tm_sec, fraction);
}

}  // namespace waymark::geo_track
