// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "particles/particle.hpp"
#include "waymark/base/api.hpp"

namespace waymark::particles {

/// The particles with their weights, in the order of their slots.
class WAYMARK_API ParticleSet {
 public:
  /// `count` >= 1 default particles.
  explicit ParticleSet(int count) : particles_(static_cast<std::size_t>(count)), log_weights_(particles_.size()) {}

  std::size_t size() const { return particles_.size(); }
  Particle& operator[](std::size_t slot) { return particles_[slot]; }
  const Particle& operator[](std::size_t slot) const { return particles_[slot]; }
  auto begin() { return particles_.begin(); }
  auto end() { return particles_.end(); }
  const std::vector<Particle>& all() const { return particles_; }
  /// Weight of a particle; normalised after `normalize`.
  double weight(std::size_t slot) const;

  /// N_eff = 1 / Σ w² of normalised weights.
  double effective_sample_size() const;
  /// Slot of the particle with the highest weight; the first of equals.
  std::size_t best() const;

  /// Normalises the weights to a sum of 1; equal weights if none is finite.
  void normalize();
  /// Systematic resampling of normalised weights, `u` uniform in (0, 1). Copies handles; weights become equal. Returns
  /// the ancestor of every slot.
  std::vector<int> resample(double u);
  /// Copies of all particles; maps as handles.
  std::vector<Particle> clone() const;
  /// Replaces all particles by as many others.
  void replace(std::vector<Particle>&& particles) { particles_ = std::move(particles); }

 private:
  void gather_weights();

  std::vector<Particle> particles_;
  std::vector<double> log_weights_;  // scratch
};

}  // namespace waymark::particles
