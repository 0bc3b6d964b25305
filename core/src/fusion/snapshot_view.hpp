// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "fusion/committed.hpp"
#include "waymark/host/fusion_settings.hpp"
#include "waymark/interface/snapshot.hpp"

namespace waymark::fusion {

/// The snapshot for sinks: the filter after one measurement.
class SnapshotView final : public Snapshot {
 public:
  SnapshotView(const Committed& committed, const std::vector<MapSlot>& maps, bool started,
               const Measurement& measurement, Fate fate, const std::optional<Datum>& datum)
      : filter_(committed.filter),
        maps_(maps),
        counters_(committed.record(measurement).state.counters),
        health_(committed.health.health()),
        started_(started),
        measurement_(measurement),
        fate_(fate),
        datum_(datum) {}

  Time stamp() const override { return started_ ? filter_.stamp() : measurement_.stamp; }
  const Measurement& measurement() const override { return measurement_; }
  Fate fate() const override { return fate_; }
  const SensorCounters& counters() const override { return counters_; }
  bool started() const override { return started_; }
  const Belief& belief() const override { return filter_.reported(); }
  const StateLayout& layout() const override { return filter_.layout(); }
  std::optional<Datum> datum() const override { return datum_; }
  double effective_sample_size() const override { return filter_.effective_sample_size(); }
  std::uint64_t mapping_steps() const override { return filter_.mapping_steps(); }
  const Health& health() const override { return health_; }
  std::vector<ParticleView> particles() const override;
  std::vector<StampedPose> best_path() const override;
  std::vector<MapDescription> best_maps(MapDetail detail) const override;

 private:
  const particles::Particle& best() const { return filter_.set()[filter_.set().best()]; }
  /// `of_best`: the grid of the best particle.
  std::optional<GridView> mixture_of(std::size_t map, const std::optional<GridView>& of_best) const;
  void make_marginal(MapDescription& map) const;
  void place_on_earth(MapDescription& map) const;

  const particles::ParticleFilter& filter_;
  const std::vector<MapSlot>& maps_;
  const SensorCounters& counters_;
  const Health& health_;
  bool started_;
  const Measurement& measurement_;
  Fate fate_;
  const std::optional<Datum>& datum_;
};

}  // namespace waymark::fusion
