// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "waymark/interface/rig.hpp"
#include "waymark/interface/snapshot.hpp"

namespace waymark::testing {

/// A run as a sink sees it, made by hand and the same every time: a robot that drives a curve, with snapshots of all
/// kinds. Nothing of it is random.
class ScriptedRun : private Snapshot {
 public:
  static constexpr std::size_t kSteps = 48;

  explicit ScriptedRun(StateLayout::Motion motion);

  static const Rig& rig();
  static std::shared_ptr<const Reference> reference();

  /// The snapshot after the measurement of a step, valid until the next call.
  const Snapshot& at(std::size_t step);
  /// The measurement of the step that `at` was called for.
  const Measurement& measurement() const override { return measurement_; }
  const Belief& belief() const override { return belief_; }
  /// What the host reports at the end, after `steps` steps.
  static RunReport report(std::size_t steps);

 private:
  Time stamp() const override { return belief_.stamp; }
  Fate fate() const override { return fate_; }
  const SensorCounters& counters() const override { return counters_; }
  bool started() const override { return started_; }
  const StateLayout& layout() const override { return layout_; }
  std::optional<Datum> datum() const override { return datum_; }
  double effective_sample_size() const override { return 7.5; }
  const Health& health() const override { return health_; }
  std::vector<ParticleView> particles() const override;
  std::vector<StampedPose> best_path() const override { return path_; }
  std::vector<MapDescription> best_maps(MapDetail detail) const override;
  std::uint64_t mapping_steps() const override { return mapping_steps_; }

  StateLayout layout_;
  Belief belief_;
  Measurement measurement_;
  Fate fate_ = Fate::before_start;
  SensorCounters counters_;
  bool started_ = false;
  std::optional<Datum> datum_;
  Health health_;
  std::vector<StampedPose> path_;
  std::uint64_t mapping_steps_ = 0;
};

}  // namespace waymark::testing
