// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

#include "bias_watch.hpp"
#include "fuse_rule.hpp"
#include "health_monitor.hpp"
#include "standstill.hpp"
#include "waymark/archive.hpp"
#include "waymark/fusion_settings.hpp"
#include "waymark/particle_filter.hpp"

namespace waymark {

/// A sensor at run time, on the committed side.
struct SensorState {
  std::shared_ptr<Sensor> sensor;  ///< null: only maps listen to it, or it is out of service
  FuseGate fuse;
  SensorCounters counters = {};
  std::array<int, UpdateList::kSlots> rejections_in_a_row = {};  ///< of each of a measurement's updates
  BiasWatch bias = {};                                           ///< of a position's innovations
  int biased = 0;                                                ///< how often that was no chance
  bool told_unheard = false;
  bool told_elsewhere = false;
};

/// Everything of the committed side that a measurement can change, but for the particles: so that it can go back.
struct Committed {
  std::vector<SensorState> sensors;
  Standstill standstill;
  HealthMonitor health;
  std::size_t events = 0;    ///< how many the host had noted
  std::size_t smoothed = 0;  ///< how many steps the smoother had
  Time last_stamp{};

  /// A copy whose sensors are clones.
  Committed clone() const;
  void save(OutArchive& out) const;
  void load(InArchive& in);
};

/// The committed side as it was before one measurement.
struct Mark {
  std::uint64_t at = 0;  ///< number of that measurement, from the start of the filter
  Time stamp{};
  ParticleFilter::State filter;
  Committed committed;
};

}  // namespace waymark
