// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "map_messages.hpp"
#include "plugins/shared/dds/writer.hpp"
#include "publisher.hpp"
#include "topic_names.hpp"

namespace waymark::ros2_publisher {

/// How often what is large is published, in the time of the measurements.
struct MapPeriods {
  Duration small;          ///< path, landmarks, updates of grids, health
  Duration full;           ///< grids as a whole, octrees
  std::size_t path_poses;  ///< at most so many
};

/// Path, maps, landmarks and health: computed only while somebody reads them, written by the publisher's thread.
class MapTopics {
 public:
  /// All arguments but `topics`, `periods` and the names must outlive the object. Throws Error.
  MapTopics(const dds::Participant& participant, Publisher& publisher, Topics topics, MapPeriods periods,
            std::string map_frame, std::vector<std::string> sensors);

  void publish(const Snapshot& snapshot);

 private:
  /// A grid that is published: as a whole, and as what has changed since.
  struct Grid {
    std::unique_ptr<dds::Writer> whole, updates;
    std::optional<GridView> full;  // as it was published
    Time published{};
  };
  std::unique_ptr<dds::Writer> writer(const std::string& topic, std::string_view type, bool is_latched) const;
  void publish_grids(std::vector<MapDescription>& maps, Time now);
  void publish_grid(Grid& grid, GridView&& view, Time now);
  bool reads_grids() const;
  template <class M>
  void send(const std::unique_ptr<dds::Writer>& writer, const M& message);

  const dds::Participant& participant_;
  Publisher& publisher_;
  Topics topics_;
  MapPeriods periods_;
  std::string map_frame_;
  std::vector<std::string> sensors_;
  std::unique_ptr<dds::Writer> path_, landmarks_, octomap_, diagnostics_;  // null: not wanted
  std::map<std::string, Grid> grids_;                                      // by map
  LandmarkMarkers markers_;
  std::optional<Time> last_small_, last_octomap_;
};

}  // namespace waymark::ros2_publisher
