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

/// What a measurement meets on its way through Fig. 2.1 of the paper. The steps are the same for the particles now, for
/// the particles at the earlier time of a measurement that comes late, and for the front, one Gaussian ahead of both.
class Horizon {
 public:
  virtual ~Horizon() = default;

  /// The mixture at the measurement's time, its pose in ENU.
  virtual const Belief& belief() = 0;
  virtual bool standing() const = 0;
  /// False if the YAML keeps this measurement out of the filter. Asked once per measurement.
  virtual bool fuses(const Measurement& m) = 0;
  /// The sensor's plugin; null if none is in service.
  virtual Sensor* sensor(const Measurement& m) = 0;
  /// The map's origin on the Earth, which a geodetic measurement may settle; null while unknown.
  virtual const Datum* datum(const Measurement& m) = 0;

  /// Follows what a motion sensor reports, before its updates. True if the robot stands, and the zero twist has
  /// replaced them.
  virtual bool follow_motion(const Measurement& m, const UpdateList& updates) = 0;
  /// Innovate, gate and update with one of the measurement's updates.
  virtual void update(const Measurement& m, std::size_t index, const Update& update, UpdateResult& result) = 0;

  /// What the map modules find in the measurement.
  virtual Extraction extract(const Measurement& m) = 0;
  /// No module has a use for it.
  virtual void skip_mapping() = 0;
  /// Refine, sample, weigh, insert, resample.
  virtual void map(const Measurement& m, const Extraction& extraction, UpdateResult& result) = 0;

  /// The plugin could not read the measurement.
  virtual void note_unusable(const Measurement& m, std::string_view why) = 0;
  /// The plugin threw something else.
  virtual void take_out_of_service(const Measurement& m, std::string_view why) = 0;
  /// After all steps.
  virtual void conclude(const Measurement& m, UpdateResult& result) = 0;
};

}  // namespace waymark::fusion
