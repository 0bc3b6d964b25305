// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "fusion/sensor_record.hpp"
#include "fusion/start_finder.hpp"
#include "waymark/host/fusion.hpp"

namespace waymark::fusion {

/// Buffers measurements until the start pose and the first motion measurement are known. Once more after the pose was
/// lost.
class Startup {
 public:
  /// `motion_from_maps`: without a motion sensor, the first mapping measurement starts the filter. `process_model` must
  /// outlive the object.
  Startup(const StartSettings& settings, const estimation::ProcessModel& process_model, Duration standstill_after,
          StartSources sources, bool motion_from_maps)
      : settings_(settings),
        sources_(sources),
        finder_(settings, process_model, standstill_after, sources),
        motion_from_maps_(motion_from_maps) {}

  /// Adds the next measurement, with its sensor's hint. Returns the start of the filter once it is known.
  std::optional<Start> process(const Measurement& m, const std::optional<StartHint>& hint,
                               const std::vector<SensorRecord>& sensors);
  /// The pose was lost: position and heading are searched with absolute sensors, whatever start the YAML gives.
  /// Without one, nothing can find them: then, and after `patience` without a position, or without both where there are
  /// maps, the filter goes on from `last_pose`.
  void search_again(Start last_pose, Duration patience, bool has_maps);
  /// The start pose, in place of one that was found already.
  void give(const GivenPose& pose);
  /// False once the start pose is found.
  bool needs_pose() const { return !start_; }
  /// Returns the buffered measurements, in the total order, and clears the buffer.
  std::vector<Measurement> release() { return std::exchange(buffer_, {}); }
  /// The missing information, as a text for users.
  std::string missing() const;

 private:
  /// What happens if nothing finds the pose.
  struct LastPose {
    Start start;
    Duration patience;
    bool has_maps;
  };
  bool has_waited_enough(const Measurement& m) const;
  std::optional<Start> at_first_motion(const std::vector<SensorRecord>& sensors) const;

  StartSettings settings_;
  StartSources sources_;
  StartFinder finder_;
  bool motion_from_maps_;
  std::optional<LastPose> last_pose_;  // of a search for a pose that was lost
  std::vector<Measurement> buffer_;
  std::optional<Start> start_;  // found, but no motion is measured yet
};

}  // namespace waymark::fusion
