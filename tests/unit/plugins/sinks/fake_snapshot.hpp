// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "temporary_folder.hpp"
#include "waymark/config/config.hpp"
#include "waymark/interface/payloads.hpp"
#include "waymark/interface/sink.hpp"
#include "waymark/interface/snapshot.hpp"
#include "waymark/plugin_loader.hpp"

/// What the tests of sinks share: a snapshot made by hand.
namespace waymark::test {

/// A snapshot whose answers are its members. Without blocks; starts as a started filter at the map's origin.
class FakeSnapshot : public Snapshot {
 public:
  explicit FakeSnapshot(StateLayout::Motion motion = StateLayout::Motion::planar) : layout_(motion, {}) {
    belief_.P = ErrorMatrix::Zero(layout_.size(), layout_.size());
    measurement_.payload = std::make_shared<WheelSpeeds>();
  }

  /// Puts the pose, the stamp and the measurement's stamp in one go.
  FakeSnapshot& at(double seconds, const Pose& T_map_base) {
    measurement_.stamp = Time{from_seconds(seconds)};
    belief_.stamp = measurement_.stamp;
    belief_.mean.T_map_base = T_map_base;
    return *this;
  }
  /// Variances of x, y [m²] and yaw [rad²].
  FakeSnapshot& pose_variance(double x, double y, double yaw) {
    const auto& i = layout_.pose_indices();
    belief_.P(i[0], i[0]) = x;
    belief_.P(i[1], i[1]) = y;
    belief_.P(i[2], i[2]) = yaw;
    return *this;
  }

  Time stamp() const override { return belief_.stamp; }
  const Measurement& measurement() const override { return measurement_; }
  Fate fate() const override { return fate_; }
  const SensorCounters& counters() const override { return counters_; }
  bool started() const override { return started_; }
  const Belief& belief() const override { return belief_; }
  const StateLayout& layout() const override { return layout_; }
  std::optional<Datum> datum() const override { return datum_; }
  double effective_sample_size() const override { return effective_sample_size_; }
  const Health& health() const override { return health_; }
  std::vector<ParticleView> particles() const override { return particles_; }
  std::vector<StampedPose> best_path() const override { return path_; }
  std::vector<MapDescription> best_maps(MapDetail) const override { return maps_; }
  std::uint64_t mapping_steps() const override { return mapping_steps_; }

  Measurement measurement_;
  Fate fate_ = Fate::fused;
  SensorCounters counters_;
  std::optional<Datum> datum_;
  bool started_ = true;
  double effective_sample_size_ = 1.0;
  std::uint64_t mapping_steps_ = 0;
  Health health_;
  std::vector<ParticleView> particles_;
  std::vector<StampedPose> path_;
  std::vector<MapDescription> maps_;
  StateLayout layout_;
  Belief belief_;
};

/// The sink plugin `name` out of the build tree, built from a YAML mapping.
inline std::shared_ptr<Sink> make_sink(std::string_view name, std::string_view yaml = "{}") {
  const PluginLoader loader({WAYMARK_PLUGIN_DIR});
  return loader.create<Sink>(name, Config::parse(yaml), Rig({}));
}

}  // namespace waymark::test
