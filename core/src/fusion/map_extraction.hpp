// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "fusion/committed.hpp"
#include "fusion/level_wait.hpp"
#include "particles/particle.hpp"
#include "waymark/host/fusion_settings.hpp"

namespace waymark {
struct Companion;
struct MotionWindow;
}  // namespace waymark

namespace waymark::fusion {

/// What the map modules extracted from one measurement.
struct Extraction {
  std::vector<particles::MappingInput> inputs;
  bool skipped = false;   ///< a module does not use the measurement
  bool unusable = false;  ///< a module rejected it as unusable
  bool held_out = false;  ///< a map that would use it is switched off
};

/// The maps of the YAML with their modules and inputs.
class MapExtraction {
 public:
  explicit MapExtraction(std::vector<MapSlot> maps)
      : maps_(std::move(maps)), unusable_(maps_.size()), enabled_(maps_.size(), true), level_(maps_.size()) {}

  const std::vector<MapSlot>& maps() const { return maps_; }
  bool empty() const { return maps_.empty(); }
  /// True if a map's information refines the pose.
  bool localizes() const;
  /// True if a map in service takes this sensor's measurements along with those of its first input.
  bool has_companion(std::uint32_t sensor) const;

  /// Switches a map on or off; it keeps its content. Throws Error if it is out of service.
  void enable(std::size_t map, bool enabled);
  bool is_enabled(std::size_t map) const { return enabled_.at(map); }

  /// The observations of every module that this measurement triggers; a map of all six of the pose waits until roll and
  /// pitch are known, if the robot has a motion sensor. A module that throws anything but DataError is taken out of
  /// service. `tilt_sigma`: σ of roll and pitch [rad], the larger one.
  Extraction extract(const Measurement& m, const MotionWindow& motion, bool has_motion_sensor, double tilt_sigma,
                     Committed& committed);
  /// Drops a module and its maps, and adds an event with the reason.
  void take_out_of_service(std::size_t map, Time stamp, std::string_view why, Committed& committed);
  /// Adds an event with the number of unusable measurements for each map that had several.
  void report(Time stamp, std::vector<Event>& events) const;

  /// The modules; their maps are the particles'. Reading throws DataError if it is of another configuration, and drops
  /// from the filter what was out of service.
  template <class Archive>
  void serialize(Archive& archive, particles::ParticleFilter& filter);

 private:
  std::vector<Companion> companions_of(const MapSlot& map, const Measurement& m, const Committed& committed) const;

  /// True while the map's first scan is still to come, since the robot's tilt is not known yet but will be.
  bool waits_for_level(std::size_t map, const Measurement& m, bool has_motion_sensor, double tilt_sigma,
                       Committed& committed);

  std::vector<MapSlot> maps_;
  std::vector<std::uint64_t> unusable_;  // per map, unusable measurements
  std::vector<bool> enabled_;            // per map
  std::vector<LevelWait> level_;         // per map
};

}  // namespace waymark::fusion
