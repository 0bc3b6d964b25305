// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

#include "fusion/fuse_rule.hpp"
#include "monitoring/bias_watch.hpp"
#include "monitoring/health_monitor.hpp"
#include "monitoring/standstill.hpp"
#include "particles/particle_filter.hpp"
#include "waymark/host/fusion_settings.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::fusion {

/// A sensor at run time, on the committed side.
struct SensorState {
  std::shared_ptr<Sensor> sensor;  ///< null: only maps listen to it, or it is out of service
  FuseGate fuse;
  SensorCounters counters = {};
  std::array<int, UpdateList::kSlots> rejections_in_a_row = {};  ///< of each of a measurement's updates
  monitoring::BiasWatch bias = {};                               ///< of a position's innovations
  int biased = 0;                                                ///< how often that was no chance
  bool told_unheard = false;
  bool told_elsewhere = false;
};

/// Everything of the committed side that a measurement can change, but for the particles: so that it can go back.
struct Committed {
  std::vector<SensorState> sensors;
  monitoring::Standstill standstill;
  monitoring::HealthMonitor health;
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
  particles::ParticleFilter::State filter;
  Committed committed;
};

}  // namespace waymark::fusion
