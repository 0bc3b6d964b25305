// SPDX-License-Identifier: Apache-2.0
#include "map_messages.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "plugins/shared/cdr/to_ros.hpp"
#include "plugins/shared/map_formats/octree_bytes.hpp"
#include "pose_messages.hpp"
#include "waymark/base/error.hpp"

namespace waymark::ros2_publisher {
namespace {

constexpr std::int8_t kUnknownCell = -1;

std::int8_t cell(std::uint8_t percent) {
  return percent == GridView::kUnknown ? kUnknownCell : static_cast<std::int8_t>(percent);
}

constexpr std::int32_t kCylinder = 3;
constexpr std::int32_t kText = 9;
constexpr std::int32_t kDelete = 2;

ros::visualization_msgs::Marker marker(const std::string& name_space, std::int32_t id, std::int32_t type,
                                       const ros::std_msgs::Header& header) {
  ros::visualization_msgs::Marker result;
  result.header = header;
  result.ns = name_space;
  result.id = id;
  result.type = type;
  return result;
}

std::int32_t id_of(const LandmarkView& landmark) { return static_cast<std::int32_t>(landmark.id & 0x7fffffff); }

}  // namespace

ros::nav_msgs::OccupancyGrid grid_message(const GridView& grid, Time stamp, const std::string& map_frame) {
  ros::nav_msgs::OccupancyGrid message;
  message.header = ros::to_ros_header(stamp, map_frame);
  message.info.map_load_time = message.header.stamp;
  message.info.resolution = static_cast<float>(grid.resolution_m);
  message.info.width = static_cast<std::uint32_t>(grid.width);
  message.info.height = static_cast<std::uint32_t>(grid.height);
  message.info.origin = to_ros(grid.T_map_grid);
  message.data.resize(grid.cells.size());
  std::ranges::transform(grid.cells, message.data.begin(), cell);
  return message;
}

bool have_same_cells(const GridView& a, const GridView& b) {
  return a.width == b.width && a.height == b.height && a.resolution_m == b.resolution_m &&
         a.T_map_grid.p == b.T_map_grid.p && a.T_map_grid.q.coeffs() == b.T_map_grid.q.coeffs();
}

std::optional<ros::map_msgs::OccupancyGridUpdate> grid_update(const GridView& full, const GridView& grid, Time stamp,
                                                              const std::string& map_frame) {
  if (!have_same_cells(full, grid)) return std::nullopt;
  int left = grid.width;
  int right = -1;
  int bottom = grid.height;
  int top = -1;
  const auto at = [&](int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(grid.width) + static_cast<std::size_t>(x);
  };
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      if (grid.cells[at(x, y)] == full.cells[at(x, y)]) continue;
      left = std::min(left, x);
      right = std::max(right, x);
      bottom = std::min(bottom, y);
      top = std::max(top, y);
    }
  }
  if (right < 0) return std::nullopt;
  ros::map_msgs::OccupancyGridUpdate message;
  message.header = ros::to_ros_header(stamp, map_frame);
  message.x = left;
  message.y = bottom;
  message.width = static_cast<std::uint32_t>(right - left + 1);
  message.height = static_cast<std::uint32_t>(top - bottom + 1);
  message.data.reserve(std::size_t{message.width} * message.height);
  for (int y = bottom; y <= top; ++y) {
    for (int x = left; x <= right; ++x) message.data.push_back(cell(grid.cells[at(x, y)]));
  }
  return message;
}

std::optional<ros::octomap_msgs::Octomap> octomap_message(const MapFile& file, Time stamp,
                                                          const std::string& map_frame) {
  if (file.extension != ".bt" && file.extension != ".ot") return std::nullopt;
  try {
    const map_formats::OctreeBytes octree(file.content, "map" + file.extension);
    ros::octomap_msgs::Octomap message;
    message.header = ros::to_ros_header(stamp, map_frame);
    message.binary = octree.is_binary();
    message.id = "OcTree";
    message.resolution = octree.resolution_m();
    // The message has what follows the header of the file.
    const auto* const first = reinterpret_cast<const std::int8_t*>(octree.content().data());
    message.data.assign(first + octree.data_begin(), first + octree.content().size());
    return message;
  } catch (const DataError&) {
    return std::nullopt;
  }
}

ros::visualization_msgs::MarkerArray LandmarkMarkers::message(const std::vector<MapDescription>& maps, Time stamp,
                                                              const std::string& map_frame) {
  constexpr double kHeight = 0.5;
  constexpr double kRadiusOfPoint = 0.05;
  constexpr double kFlat = 0.01;
  const double kChi = std::sqrt(5.991);  // 95 % of two degrees of freedom
  const ros::std_msgs::Header header = ros::to_ros_header(stamp, map_frame);
  ros::visualization_msgs::MarkerArray message;
  std::set<std::pair<std::string, std::int32_t>> shown;
  for (const MapDescription& map : maps) {
    for (const LandmarkView& landmark : map.landmarks) {
      if (!landmark.p_map.allFinite()) continue;
      const double x = landmark.p_map.x();
      const double y = landmark.p_map.y();
      shown.emplace(map.module, id_of(landmark));

      auto body = marker(map.module, id_of(landmark), kCylinder, header);
      const double radius = std::isfinite(landmark.radius_m) ? landmark.radius_m : kRadiusOfPoint;
      body.pose.position = {x, y, 0.5 * kHeight};
      body.scale = {2.0 * radius, 2.0 * radius, kHeight};
      body.color = landmark.confirmed ? ros::std_msgs::ColorRGBA{0.1f, 0.5f, 0.9f, 0.9f}
                                      : ros::std_msgs::ColorRGBA{0.6f, 0.6f, 0.6f, 0.5f};
      message.markers.push_back(body);

      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(landmark.P.topLeftCorner<2, 2>());
      const Eigen::Vector2d half = kChi * axes.eigenvalues().cwiseMax(0.0).cwiseSqrt();
      const double yaw = std::atan2(axes.eigenvectors()(1, 1), axes.eigenvectors()(0, 1));
      auto ellipse = marker(map.module + "/95%", id_of(landmark), kCylinder, header);
      ellipse.pose = to_ros(Pose::planar(x, y, yaw));
      ellipse.scale = {std::max(2.0 * half[1], kFlat), std::max(2.0 * half[0], kFlat), kFlat};
      ellipse.color = {0.9f, 0.4f, 0.1f, 0.4f};
      message.markers.push_back(ellipse);

      auto number = marker(map.module + "/number", id_of(landmark), kText, header);
      number.pose.position = {x, y, kHeight + 0.2};
      number.scale = {0.0, 0.0, 0.2};
      number.color = {0.0f, 0.0f, 0.0f, 1.0f};
      number.text = fmt::format("{}", landmark.id);
      message.markers.push_back(number);
    }
  }
  for (const auto& [map, id] : shown_) {
    if (shown.contains({map, id})) continue;
    for (const char* part : {"", "/95%", "/number"}) {
      auto gone = marker(map + part, id, kCylinder, header);
      gone.action = kDelete;
      message.markers.push_back(gone);
    }
  }
  shown_ = std::move(shown);
  return message;
}

ros::nav_msgs::Path path_message(const std::vector<StampedPose>& path, std::size_t most, Time stamp,
                                 const std::string& map_frame) {
  ros::nav_msgs::Path message;
  message.header = ros::to_ros_header(stamp, map_frame);
  const std::size_t step = path.empty() ? 1 : (path.size() + most - 1) / most;
  // Counted from the end, so that the last pose is among them.
  for (std::size_t back = 0; back < path.size(); back += step) {
    const StampedPose& pose = path[path.size() - 1 - back];
    message.poses.push_back({ros::to_ros_header(pose.stamp, map_frame), to_ros(pose.T_map_base)});
  }
  std::ranges::reverse(message.poses);
  return message;
}

}  // namespace waymark::ros2_publisher
