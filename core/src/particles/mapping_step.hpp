// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "particles/instant.hpp"
#include "particles/particle_set.hpp"
#include "particles/workers.hpp"
#include "waymark/math/random.hpp"

namespace waymark::particles {

/// What draws random numbers for the particles: counter-based streams, so that no order of calls enters.
struct RandomStreams {
  std::uint64_t seed = 1;
  /// The stream of one particle (or -1: of none) at one time, for one purpose.
  Random operator()(int slot, Time stamp, std::uint32_t purpose) const {
    return Random({seed, static_cast<std::uint32_t>(slot), stamp.time_since_epoch().count(), purpose});
  }
};

/// The parts of a mapping step that read and write maps: every module refines every particle's belief in turn and
/// weighs it by its evidence; after sampling, every particle writes its own maps. A module that throws for one particle
/// loses its part for all, or the weights were not comparable.
class MappingStep {
 public:
  /// Layout and workers must outlive the object.
  MappingStep(const StateLayout& layout, Workers& workers, const RandomStreams& streams, std::size_t particles);

  /// Refines the beliefs of `at` and adds the evidence to the weights, unnormalised. `stamp`: of the particles now, for
  /// the random streams. Calls `drop_module(module)` for what threw.
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

  /// Each particle writes its own maps. One module after the other, so that one that throws keeps no other from
  /// writing.
  template <class DropModule>
  void insert(ParticleSet& particles, Instant& at, std::span<const MappingInput> inputs, MappingFailures& failures,
              const DropModule& drop_module) {
    for (std::size_t input = 0; input < inputs.size(); ++input) {
      insert_each(particles, at, inputs, input);
      collect_failures(inputs, failures, drop_module);
    }
  }

  /// True if, in the last refinement, some map will write at a place that the pose of this particle decides.
  bool writes(std::size_t slot) const { return scratch_[slot].writes; }
  /// True if, in the last refinement, maps gave half of the particles or more information about their pose.
  bool located() const { return located_; }
  /// The belief of a particle before the last refinement.
  const Belief& prior(std::size_t slot) const { return scratch_[slot].prior; }

 private:
  struct Scratch {  // per slot, kept between calls so that warm steps do not allocate
    Belief prior;   // before refinement, to start over when a module fails
    std::vector<Refinement> refinements;
    double log_evidence = 0.0;
    bool writes = false;
    bool informed = false;  // some map gave information about the pose
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
  std::vector<Scratch> scratch_;
  bool located_ = false;
};

}  // namespace waymark::particles
