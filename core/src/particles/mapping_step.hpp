// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "particles/instant.hpp"
#include "particles/particle_set.hpp"
#include "particles/workers.hpp"
#include "waymark/base/api.hpp"
#include "waymark/math/random.hpp"

namespace waymark::particles {

/// Random streams of the particles. Counter-based, so the order of calls has no effect.
struct RandomStreams {
  std::uint64_t seed = 1;
  /// The stream of one particle (-1: of all together) at one time, for one purpose.
  Random operator()(int slot, Time stamp, std::uint32_t purpose) const {
    return Random({seed, static_cast<std::uint32_t>(slot), stamp.time_since_epoch().count(), purpose});
  }
};

/// How far the maps' information lies from the prior.
struct MapInnovation {
  double nis = 0.0;
  int dof = 0;
};

/// Whether a particle may use a match that lies beyond what its prior expects: the surfaces that were matched, in the
/// base frame, and the pose of the match. Called from many threads.
using MayJump = std::function<bool(std::span<const Eigen::Vector2d> points_base, const Pose& T_map_base)>;

/// The parts of a mapping step that read and write maps. Every module refines every particle's belief in turn and
/// weights it by its evidence; after sampling, every particle writes its own maps. If a module throws for one particle,
/// its part is discarded for all, since the weights would not be comparable.
class WAYMARK_API MappingStep {
 public:
  /// Layout and workers must outlive the object.
  MappingStep(const StateLayout& layout, Workers& workers, const RandomStreams& streams, std::size_t particles,
              MayJump may_jump);

  /// Refines the beliefs of `at` and adds the evidence to the weights, unnormalised. `stamp`: of the present particles,
  /// for the random streams. Calls `drop_module(module)` for every module that threw.
  template <class DropModule>
  void refine(ParticleSet& particles, Instant& at, std::span<const MappingInput> inputs, Time stamp,
              std::uint32_t sensor, MappingFailures& failures, const DropModule& drop_module) {
    keep_priors(at, particles.size());
    refine_each(particles, at, inputs, stamp, sensor);
    while (collect_failures(inputs, failures, drop_module)) {
      restore_priors(at, particles.size());
      refine_each(particles, at, inputs, stamp, sensor);
    }
    weigh(particles);
  }

  /// Each particle writes its own maps, one module after the other, so that one that throws does not prevent others
  /// from writing.
  template <class DropModule>
  void insert(ParticleSet& particles, Instant& at, std::span<const MappingInput> inputs, MappingFailures& failures,
              const DropModule& drop_module) {
    for (std::size_t input = 0; input < inputs.size(); ++input) {
      insert_each(particles, at, inputs, input);
      collect_failures(inputs, failures, drop_module);
    }
  }

  /// True if, in the last refinement, a map will write something that depends on this particle's pose.
  bool writes(std::size_t slot) const { return scratch_[slot].writes; }
  /// True if, in the last refinement, this particle's maps had nothing to match all six of the pose to yet.
  bool begins_spatial_map(std::size_t slot) const { return !scratch_[slot].compared; }
  /// True if, in the last refinement, maps gave half of the particles or more information about their pose.
  bool localized() const { return localized_; }
  /// True if, in the last refinement, the observation did not fit the maps of half of the particles or more.
  bool failed() const { return failed_; }
  /// True if it contradicted the maps of half of the particles or more where they expected it, even after a search.
  bool searched() const { return searched_; }
  /// Of the last refinement, mean over the particles; without degrees of freedom if no map gave information.
  const MapInnovation& innovation() const { return innovation_; }
  /// What module `module` returned for a particle in the last refinement, and the mean that it refined.
  const Refinement& refinement(std::size_t slot, int module) const {
    return scratch_[slot].refinements[static_cast<std::size_t>(module)];
  }
  const Pose& refined_from(std::size_t slot, int module) const {
    return scratch_[slot].refined_from[static_cast<std::size_t>(module)];
  }
  /// The belief of a particle before the last refinement.
  const Belief& prior(std::size_t slot) const { return scratch_[slot].prior; }

 private:
  struct Scratch {  // per slot, kept between calls so that warm steps do not allocate
    Belief prior;   // before refinement, restored if a module fails
    std::vector<Refinement> refinements;
    std::vector<Pose> refined_from;  // the prior mean of each
    double log_evidence = 0.0;
    bool writes = false;
    bool informed = false;  // some map gave information about the pose
    bool failed = false;    // some map that localises found no fit
    bool searched = false;  // it contradicts some map that localises
    MapInnovation innovation;
    bool compared = false;  // some map had something to match all six of the pose to
    std::string failure;
    int failed_input = -1;
  };

  void keep_priors(Instant& at, std::size_t particles);
  void restore_priors(Instant& at, std::size_t particles);
  void refine_each(const ParticleSet& particles, Instant& at, std::span<const MappingInput> inputs, Time stamp,
                   std::uint32_t sensor);
  void refine_one(std::size_t slot, const Particle& particle, Belief& belief, std::span<const MappingInput> inputs,
                  Time stamp, std::uint32_t sensor);
  void refine_by(const MappingInput& input, const ParticleMap& map, const PoseGaussian& prior, const Pose& start,
                 Belief& belief, Scratch& scratch) const;
  void refuse_jump(const MappingInput& input, const ParticleMap& map, const PoseGaussian& prior,
                   Refinement& refinement) const;
  bool add_information(const Refinement& refinement, double share, Belief& belief, MapInnovation& innovation) const;
  bool apply(const Refinement& refinement, double share, Belief& belief) const;
  PoseGaussian pose_of(const Belief& belief) const;
  Pose draw_start(std::size_t slot, const PoseGaussian& prior, Time stamp, std::uint32_t sensor) const;
  void weigh(ParticleSet& particles);
  void insert_each(ParticleSet& particles, Instant& at, std::span<const MappingInput> inputs, std::size_t input);
  void insert_one(std::size_t slot, Particle& particle, const Belief& belief, std::span<const MappingInput> inputs,
                  std::size_t input);
  template <class DropModule>
  bool collect_failures(std::span<const MappingInput> inputs, MappingFailures& failures,
                        const DropModule& drop_module) {
    bool any = false;
    for (const Scratch& scratch : scratch_) {
      if (scratch.failed_input < 0) continue;
      any = true;
      if (note_failure(scratch, failures)) drop_module(inputs[static_cast<std::size_t>(scratch.failed_input)].module);
    }
    return any;
  }
  static bool note_failure(const Scratch& scratch, MappingFailures& failures);

  const StateLayout& layout_;
  Workers& workers_;
  RandomStreams streams_;
  MayJump may_jump_;
  std::vector<Scratch> scratch_;
  bool localized_ = false;
  bool failed_ = false;
  bool searched_ = false;
  MapInnovation innovation_;
};

}  // namespace waymark::particles
