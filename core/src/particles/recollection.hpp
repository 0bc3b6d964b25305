// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "estimation/past_belief.hpp"
#include "estimation/process_model.hpp"
#include "particles/instant.hpp"
#include "particles/mixture_moments.hpp"
#include "particles/particle_set.hpp"
#include "particles/past_beliefs.hpp"
#include "particles/workers.hpp"

namespace waymark::particles {

/// The particles at the time of a late measurement (docs/math/time.md). Sampled paths and maps stay as they are; the
/// weights, and the blocks that are Gaussian given the path, are updated.
class Recollection final : public Instant {
 public:
  /// All must outlive the object. `span`: beliefs are stored over this time; zero: none.
  Recollection(const estimation::ProcessModel& process, const ParticleSet& particles, MixtureMoments& moments,
               Workers& workers, Duration span);

  /// Stores the present beliefs, if a record is due.
  void remember();
  /// Computes every particle's belief at `stamp`, which is not later than now. False if no beliefs of that time are
  /// stored. Call it before every update, since an update changes the past beliefs.
  bool recall(Time stamp);

  PastBeliefs& past() { return past_; }
  const PastBeliefs& past() const { return past_; }

  Belief& belief(std::size_t slot) override { return recalled_[slot].past; }
  const Belief& mixture() override { return mixture_; }
  void carry_gain(std::size_t slot, const estimation::StateJacobian& H,
                  estimation::ekf::Innovation& innovation) override;
  void sample(std::uint32_t /*sensor*/) override {}
  void conclude_mapping(std::uint32_t /*sensor*/) override {}

 private:
  const estimation::ProcessModel& process_;
  const ParticleSet& particles_;
  MixtureMoments& moments_;
  Workers& workers_;
  PastBeliefs past_;
  std::vector<estimation::PastBelief> recalled_;  // one per slot
  std::vector<const Belief*> beliefs_;            // scratch: one per slot
  Belief mixture_;
};

}  // namespace waymark::particles
