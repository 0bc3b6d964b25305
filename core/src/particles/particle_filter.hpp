// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "estimation/georeference.hpp"
#include "estimation/process_model.hpp"
#include "particles/instant.hpp"
#include "particles/mapping_step.hpp"
#include "particles/mixture_moments.hpp"
#include "particles/particle_set.hpp"
#include "particles/recollection.hpp"
#include "particles/update_step.hpp"
#include "particles/workers.hpp"
#include "waymark/base/api.hpp"
#include "waymark/host/filter_settings.hpp"
#include "waymark/interface/map_module.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::particles {

/// The Rao-Blackwellized particle filter (T. Emter; FastSLAM 2.0 after M. Montemerlo et al., IJCAI 2003): every
/// particle has its own EKF, its own maps and its own data association. With one particle and no maps it is a plain
/// EKF. The same input gives the same bytes with any number of threads.
class WAYMARK_API ParticleFilter {
 public:
  /// `process` and its layout must outlive the filter. `georeference`: the map's place on the Earth is in the state.
  ParticleFilter(const estimation::ProcessModel& process, std::vector<std::shared_ptr<MapModule>> modules,
                 const ParticleFilterSettings& settings,
                 std::optional<estimation::Georeference> georeference = std::nullopt);
  ~ParticleFilter();
  ParticleFilter(const ParticleFilter&) = delete;
  ParticleFilter& operator=(const ParticleFilter&) = delete;

  /// Sets all particles to `prior`; if `draw`, each of several draws its pose from it (with the sampling fraction), and
  /// one alone keeps it whole. With a georeference nothing is drawn: the start pose is the map's origin, and the prior
  /// becomes the georeference's. Maps become empty.
  void start(const Belief& prior, bool draw);

  Time stamp() const { return set_[0].belief.stamp; }
  void predict(Time to, bool standing);

  /// The particles now.
  Instant& now();
  /// The particles at an earlier time, for a measurement that comes late; valid until the filter changes. Null if that
  /// is forgotten.
  Instant* recall(Time stamp);
  /// Keeps the present beliefs for `recall`, if it is time for it.
  void remember() { recollection_.remember(); }

  /// Applies one measurement model to every particle, gated on the mixture's innovation, and adds the log evidence to
  /// the weights. A gated-out update counts in the weight with its likelihood clamped at the gate. Throws Error if the
  /// model throws.
  MixtureOutcome update(Instant& at, const Update& model, const UpdatePolicy& policy);
  MixtureOutcome update(const Update& model, const UpdatePolicy& policy) { return update(now(), model, policy); }

  /// One mapping step: refine, sample, weigh, insert, resample, with a barrier between. In the past nothing is sampled
  /// anew. Returns the inputs whose modules threw: their part was discarded for all particles and their maps are gone.
  MappingFailures map(Instant& at, std::span<const MappingInput> inputs, std::uint32_t sensor);
  MappingFailures map(std::span<const MappingInput> inputs, std::uint32_t sensor) { return map(now(), inputs, sensor); }
  /// True if, in the last mapping step, maps gave half of the particles or more information about their pose.
  bool located() const { return mapping_.located(); }

  /// Sets velocity and rate to zero, for a robot that stands.
  void stop();
  /// Gives velocity and rate a fresh, uncorrelated covariance.
  void release(double velocity_sigma, double rate_sigma);
  /// Adds variance to x, y and yaw of every particle, so that a filter that is wrong can be corrected again; with a
  /// georeference to the map's place on the Earth, since the particles are located in the map.
  void inflate_pose(double position_variance, double yaw_variance);
  /// Appends the present poses to the paths, for hosts without maps.
  void record_path();
  /// Appends them as dead reckoning, which the next mapping step corrects.
  void record_tentative_path();
  /// Resamples if N_eff is below the threshold; `map` does so by itself.
  void resample_if_needed(std::uint32_t sensor);
  /// Takes a module out of service: its maps are dropped.
  void drop_module(int module);

  const ParticleSet& set() const { return set_; }
  const std::vector<Particle>& particles() const { return set_.all(); }
  const StateLayout& layout() const { return process_.layout(); }
  const std::optional<estimation::Georeference>& georeference() const { return georeference_; }
  /// Where this particle has the map on the Earth; the identity without a georeference.
  Pose T_enu_map(const Particle& particle) const {
    return georeference_ ? georeference_->T_enu_map(particle.belief.mean) : Pose{};
  }
  /// Moments of the mixture, the poses in ENU: weighted mean and covariance, brought up to date. After a mapping step,
  /// until the next change: of the refined Gaussians *before* sampling, since a sampled pose has no covariance of its
  /// own.
  const Belief& mixture();
  /// The same; the filter must not have changed since it was brought up to date.
  const Belief& mixture() const;
  double effective_sample_size() const { return set_.effective_sample_size(); }
  std::uint64_t resamplings() const { return resamplings_; }
  std::uint64_t mapping_steps() const { return mapping_steps_; }

  /// What the particles are, to roll back to: poses, weights, paths, maps as handles.
  struct State {
    std::vector<Particle> particles;
    std::uint64_t resamplings = 0;
    std::uint64_t mapping_steps = 0;
  };
  State state() const;
  void restore(const State& state);
  /// The filter on a checkpoint. Reading throws DataError if it is of another configuration.
  void save(OutArchive& out) const;
  void load(InArchive& in);
  /// A state to roll back to on a checkpoint; the same.
  template <class Archive>
  void serialize(Archive& archive, State& state) const;

 private:
  template <class Archive>
  void serialize_rest(Archive& archive);

  class Present;

  const estimation::ProcessModel& process_;
  std::vector<std::shared_ptr<MapModule>> modules_;
  ParticleFilterSettings settings_;
  std::optional<estimation::Georeference> georeference_;
  Workers workers_;
  RandomStreams streams_;
  ParticleSet set_;
  MixtureMoments moments_;
  UpdateStep updates_;
  MappingStep mapping_;
  Recollection recollection_;
  std::unique_ptr<Present> now_;
  Belief mixture_;
  bool mixture_is_current_ = false;
  std::vector<const Belief*> beliefs_;  // scratch of mixture(): one per slot
  std::uint64_t resamplings_ = 0;
  std::uint64_t mapping_steps_ = 0;
};

}  // namespace waymark::particles
