// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string_view>

#include "fusion/map_extraction.hpp"
#include "monitoring/health_monitor.hpp"
#include "particles/particle.hpp"
#include "waymark/interface/sensor.hpp"

namespace waymark::fusion {

using monitoring::UpdateResult;

/// The state on which a measurement takes the steps of Fig. 2.1 of the paper. The steps are the same for the present
/// particles, for the particles at the earlier time of a late measurement, and for the front, one Gaussian ahead of
/// both.
class Horizon {
 public:
  virtual ~Horizon() = default;

  /// The mixture at the measurement's time, its pose in ENU.
  virtual const Belief& belief() = 0;
  virtual bool standing() const = 0;
  /// False if the YAML holds this measurement out. Called once per measurement.
  virtual bool fuses(const Measurement& m) = 0;
  /// False if the measurement is evaluated only (SensorMode::shadow): the pose does not depend on it.
  virtual bool steers(const Measurement& m) const = 0;
  /// The sensor's plugin; null if none is in service.
  virtual Sensor* sensor(const Measurement& m) = 0;
  /// The map's origin on the Earth, which a geodetic measurement may define; null while unknown.
  virtual const Datum* datum(const Measurement& m) = 0;

  /// Applies the motion report of a motion sensor, before its updates. True at standstill if the zero twist replaces
  /// them.
  virtual bool follow_motion(const Measurement& m, const UpdateList& updates) = 0;
  /// Innovates, gates and updates with one of the measurement's updates.
  virtual void update(const Measurement& m, std::size_t index, const Update& update, UpdateResult& result) = 0;

  /// The observations of the map modules that this measurement triggers.
  virtual Extraction extract(const Measurement& m) = 0;
  /// No module uses the measurement.
  virtual void skip_mapping() = 0;
  /// Refine, sample, weigh, insert, resample.
  virtual void map(const Measurement& m, const Extraction& extraction, UpdateResult& result) = 0;

  /// The plugin rejected the measurement as unusable.
  virtual void note_unusable(const Measurement& m, std::string_view why) = 0;
  /// The plugin threw another exception.
  virtual void take_out_of_service(const Measurement& m, std::string_view why) = 0;
  /// After all steps.
  virtual void conclude(const Measurement& m, UpdateResult& result) = 0;
};

}  // namespace waymark::fusion
