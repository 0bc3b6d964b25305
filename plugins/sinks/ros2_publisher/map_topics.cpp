// SPDX-License-Identifier: Apache-2.0
#include "map_topics.hpp"

#include <algorithm>
#include <utility>

#include "diagnostics_message.hpp"
#include "plugins/shared/cdr/message.hpp"

namespace waymark::ros2_publisher {
namespace {

constexpr std::chrono::milliseconds kPatienceOfMaps{100};

bool is_due(const std::optional<Time>& last, Time now, Duration period) {
  return !last || now - *last >= period || now < *last;
}

bool is_read(const std::unique_ptr<dds::Writer>& writer) { return writer && writer->readers() > 0; }

}  // namespace

MapTopics::MapTopics(const dds::Participant& participant, Publisher& publisher, Topics topics, MapPeriods periods,
                     std::string map_frame, std::vector<std::string> sensors)
    : participant_(participant),
      publisher_(publisher),
      topics_(std::move(topics)),
      periods_(periods),
      map_frame_(std::move(map_frame)),
      sensors_(std::move(sensors)) {
  if (topics_.has("path")) path_ = writer(topics_.path, ros::nav_msgs::Path::kType, false);
  if (topics_.has("landmarks"))
    landmarks_ = writer(topics_.landmarks, ros::visualization_msgs::MarkerArray::kType, true);
  if (topics_.has("octomap")) octomap_ = writer(topics_.octomap, ros::octomap_msgs::Octomap::kType, true);
  if (topics_.has("diagnostics"))
    diagnostics_ = writer(topics_.diagnostics, ros::diagnostic_msgs::DiagnosticArray::kType, false);
}

std::unique_ptr<dds::Writer> MapTopics::writer(const std::string& topic, std::string_view type, bool is_latched) const {
  const dds::Quality quality{.reliable = true, .latched = is_latched, .depth = is_latched ? 1 : 10};
  return std::make_unique<dds::Writer>(participant_, topic, std::string(type), quality, kPatienceOfMaps);
}

template <class M>
void MapTopics::send(const std::unique_ptr<dds::Writer>& to, const M& message) {
  publisher_.send(*to, ros::to_cdr(message));
}

bool MapTopics::reads_grids() const {
  return std::ranges::any_of(grids_,
                             [](const auto& one) { return is_read(one.second.whole) || is_read(one.second.updates); });
}

void MapTopics::publish(const Snapshot& snapshot) {
  const Time now = snapshot.stamp();
  if (!is_due(last_small_, now, periods_.small)) return;
  last_small_ = now;
  if (is_read(diagnostics_)) send(diagnostics_, diagnostics_message(snapshot.health(), sensors_, now));
  if (!snapshot.started()) return;
  if (is_read(path_)) send(path_, path_message(snapshot.best_path(), periods_.path_poses, now, map_frame_));
  // Which maps have grids shows when they are asked for one.
  const bool wants_grids = topics_.has("map") && (grids_.empty() || reads_grids());
  if (wants_grids || is_read(landmarks_)) {
    std::vector<MapDescription> maps = snapshot.best_maps(wants_grids ? MapDetail::with_grids : MapDetail::summary);
    if (is_read(landmarks_)) send(landmarks_, markers_.message(maps, now, map_frame_));
    if (wants_grids) publish_grids(maps, now);
  }
  if (!is_read(octomap_) || !is_due(last_octomap_, now, periods_.full)) return;
  last_octomap_ = now;
  for (const MapDescription& map : snapshot.best_maps(MapDetail::with_files)) {
    for (const MapFile& file : map.files) {
      if (const auto message = octomap_message(file, now, map_frame_)) return send(octomap_, *message);
    }
  }
}

void MapTopics::publish_grids(std::vector<MapDescription>& maps, Time now) {
  for (MapDescription& map : maps) {
    if (!map.grid || map.grid->cells.empty()) continue;
    Grid& grid = grids_[map.module];
    if (!grid.whole) {
      // The first one is the map; a robot with several has the others under their names.
      const std::string topic = grids_.size() == 1 ? topics_.map : topics_.map + "/" + map.module;
      grid.whole = writer(topic, ros::nav_msgs::OccupancyGrid::kType, true);
      grid.updates = writer(topic + "_updates", ros::map_msgs::OccupancyGridUpdate::kType, false);
    }
    publish_grid(grid, std::move(*map.grid), now);
  }
}

void MapTopics::publish_grid(Grid& grid, GridView&& view, Time now) {
  const bool is_changed = !grid.full || !have_same_cells(*grid.full, view);
  if (is_changed || now - grid.published >= periods_.full || now < grid.published) {
    if (grid.full && !is_changed && grid.full->cells == view.cells) return;
    send(grid.whole, grid_message(view, now, map_frame_));
    grid.full = std::move(view);
    grid.published = now;
  } else if (const auto update = grid_update(*grid.full, view, now, map_frame_)) {
    send(grid.updates, *update);
  }
}

}  // namespace waymark::ros2_publisher
