// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "watched_sensor.hpp"
#include "waymark/host/robot.hpp"

namespace waymark::host::diagnosis {

/// Keeps of every measurement what the comparisons need: angles and ways on a grid of time, fixes, motions of scanners,
/// magnitudes. One window of a log at a time; nothing here depends on the filter.
class Watch {
 public:
  explicit Watch(const Robot& robot);

  /// Takes a measurement, in order of arrival. `Measurement::sensor` is an index into the robot's sensors.
  void take(const Measurement& measurement);
  /// Notes the stamp of a measurement, and nothing else of it.
  void note(const Measurement& measurement);
  /// True if every sensor has delivered.
  bool has_all_sensors() const;

  /// Time of the newest measurement in the window [s], and whether the window is full.
  double newest() const { return newest_; }
  bool is_full() const { return newest_ >= Track::kLength; }
  /// Begins a new window with the next measurement.
  void clear_window();
  /// Stamp of a time in the window [s].
  Time stamp(double t) const;

  const std::vector<WatchedSensor>& sensors() const { return sensors_; }
  const std::optional<Datum>& datum() const { return datum_; }
  bool datum_is_given() const { return datum_is_given_; }

 private:
  void take_motion(WatchedSensor& sensor, double t, const ObservedMotion& motion);
  void take_scan(WatchedSensor& sensor, double t, const LaserScan& scan);
  void note_stamp(std::uint32_t index, Time stamp);
  void take_raw(WatchedSensor& sensor, const Measurement& measurement);

  const Robot& robot_;
  std::vector<WatchedSensor> sensors_;
  std::optional<Datum> datum_;
  bool datum_is_given_ = false;
  std::optional<Time> begin_;  // of the window
  double newest_ = 0.0;
  int astray_ = 0;  // measurements in a row that are far from the window
};

}  // namespace waymark::host::diagnosis
