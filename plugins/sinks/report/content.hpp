// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "outage_log.hpp"
#include "plugins/shared/run_views/health_changes.hpp"
#include "sensor_series.hpp"
#include "track.hpp"
#include "waymark/interface/snapshot.hpp"

namespace waymark::report {

/// What a report shows, in the map's frame.
struct Content {
  std::string name;
  std::string config;
  Time first{};  ///< stamps of the first and the last measurement
  Time last{};
  bool is_spatial = false;
  std::vector<TrackRow> track;
  /// Own states of sensors, in the order of TrackRow::block.
  struct State {
    std::string sensor;
    std::string name;  ///< with unit, as BlockState has it
  };
  std::vector<State> states;
  std::vector<SensorSeries::Row> sensor_series;
  std::shared_ptr<const Reference> reference;  ///< in the map's frame; null if there is none
  std::optional<Pose> reference_alignment;     ///< T_map_reference, if it was fitted
  struct Fixes {
    std::string kind;  ///< "used", "rejected", "held out"
    std::size_t count = 0;
    std::vector<Eigen::Vector2d> positions;  ///< east, north [m]
  };
  std::vector<Fixes> fixes;
  struct SensorOutages {
    std::string sensor;
    std::vector<Outage> outages;
  };
  std::vector<SensorOutages> outages;
  static constexpr std::size_t kMostHealthChanges = 2000;
  run_views::HealthChanges health{kMostHealthChanges, run_views::HealthChanges::Before::unknown};
  RunReport run;

  /// The end of the run; absent if the filter never started.
  struct End {
    std::vector<ParticleView> particles;
    std::vector<StampedPose> best_path;
    std::vector<MapDescription> maps;
  };
  std::optional<End> end;
};

/// The content as one JSON document. The same content gives the same bytes. Nothing in it ends a `<script>`.
std::string to_json(const Content& content);

}  // namespace waymark::report
