// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "plugins/shared/cdr/ros/nav_msgs.hpp"
#include "plugins/shared/cdr/ros/visualization_msgs.hpp"
#include "waymark/interface/map_view.hpp"
#include "waymark/interface/snapshot.hpp"

namespace waymark::ros2_publisher {

ros::nav_msgs::OccupancyGrid grid_message(const GridView& grid, Time stamp, const std::string& map_frame);

/// The rectangle of cells of `grid` that are not those of `full`, which was sent as a whole: with both, a reader has
/// `grid`, whatever updates it missed. Nothing if the two differ in place or size, or not at all.
std::optional<ros::map_msgs::OccupancyGridUpdate> grid_update(const GridView& full, const GridView& grid, Time stamp,
                                                              const std::string& map_frame);
/// True if both have the same cells, whatever is in them.
bool have_same_cells(const GridView& a, const GridView& b);

/// A file of OctoMap (`.bt`, `.ot`) as a message; nothing if it is none.
std::optional<ros::octomap_msgs::Octomap> octomap_message(const MapFile& file, Time stamp,
                                                          const std::string& map_frame);

/// Landmarks as cylinders, with their ellipses of 95 % and numbers. What was shown before, and is not there any more,
/// is deleted.
class LandmarkMarkers {
 public:
  ros::visualization_msgs::MarkerArray message(const std::vector<MapDescription>& maps, Time stamp,
                                               const std::string& map_frame);

 private:
  std::set<std::pair<std::string, std::int32_t>> shown_;  // map, id
};

/// At most `most` poses, evenly thinned; the last one is there.
ros::nav_msgs::Path path_message(const std::vector<StampedPose>& path, std::size_t most, Time stamp,
                                 const std::string& map_frame);

}  // namespace waymark::ros2_publisher
