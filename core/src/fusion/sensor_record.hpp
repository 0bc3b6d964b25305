// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>

#include "fusion/fuse_gate.hpp"
#include "monitoring/bias_watch.hpp"
#include "particles/particle.hpp"
#include "waymark/base/error.hpp"
#include "waymark/host/fusion_settings.hpp"
#include "waymark/interface/measurement.hpp"
#include "waymark/interface/snapshot.hpp"
#include "waymark/interface/update.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::fusion {

/// The way since the last accepted position, in ENU [m]; goes on after a rejected one until its direction is known.
struct WaySinceFix {
  Eigen::Vector2d z = Eigen::Vector2d::Zero();          ///< that position, of the base
  Eigen::Vector2d p = Eigen::Vector2d::Zero();          ///< position of the belief after the last update
  Eigen::Vector2d predicted = Eigen::Vector2d::Zero();  ///< the way of the predictions alone
  bool open = false;                                    ///< a position was rejected

  template <class Archive>
  void serialize(Archive& archive) {
    archive(z, p, predicted, open);
  }
};

/// State of a sensor that a rollback restores.
struct SensorState {
  static constexpr int kMostCounted = 1 << 30;  ///< in a checkpoint
  std::shared_ptr<Sensor> sensor;               ///< null: for maps only, or out of service
  FuseGate fuse;
  SensorCounters counters = {};
  std::array<int, UpdateList::kSlots> rejections_in_a_row = {};  ///< of each of a measurement's updates
  std::optional<WaySinceFix> way = {};
  monitoring::BiasWatch bias = {};    ///< of a position's innovations
  int biased = 0;                     ///< how often they were biased
  int since_surprise = kMostCounted;  ///< positions since one that was fused although it was beyond the usual gate
  bool ignored_noted = false;         ///< there is an event already
  bool not_localized_noted = false;
  bool measures_velocity = false;  ///< one of its updates did

  /// A copy with a clone of the sensor.
  SensorState clone() const;
  /// Reading throws DataError if a sensor is in service that this host lacks.
  template <class Archive>
  void serialize(Archive& archive) {
    archive(fuse, counters);
    for (int& rejections : rejections_in_a_row) archive.within(rejections, 0, kMostCounted);
    archive(way, bias);
    archive.within(biased, 0, kMostCounted);
    archive.within(since_surprise, 0, kMostCounted);
    archive(ignored_noted, not_localized_noted, measures_velocity);
    bool in_service = sensor != nullptr;
    archive(in_service);
    if (in_service && !sensor) throw DataError("the checkpoint has a sensor in service that the configuration lacks");
    if (!in_service) sensor = nullptr;
    if (sensor) archive(*sensor);
  }
};

/// One sensor at run time.
struct SensorRecord {
  SensorSlot slot;
  particles::UpdatePolicy policy;
  bool triggers_map = false;
  SensorTraits traits;  ///< of the plugin, if there is one
  SensorState state;

  SensorMode mode = SensorMode::fused;  ///< set by commands: not rolled back

  // Counted on arrival: not rolled back.
  std::uint64_t mistimed = 0;
  bool too_late_noted = false;             ///< there is an event already
  std::optional<Measurement> newest = {};  ///< for maps with several inputs

  /// Subtracts the sensor's delay from the stamp. A stamp out of range stays out of range.
  void correct_delay(Measurement& m) const { m.stamp = moved(m.stamp, -slot.delay).value_or(Time::min()); }
};

}  // namespace waymark::fusion
