// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "particles/particle.hpp"

namespace waymark::particles {

/// The particles with their normalised weights.
class WAYMARK_API ParticleSet {
 public:
  explicit ParticleSet(int count) : particles_(static_cast<std::size_t>(count)), log_weights_(particles_.size()) {}

  std::size_t size() const { return particles_.size(); }
  Particle& operator[](std::size_t slot) { return particles_[slot]; }
  const Particle& operator[](std::size_t slot) const { return particles_[slot]; }
  auto begin() { return particles_.begin(); }
  auto end() { return particles_.end(); }
  const std::vector<Particle>& all() const { return particles_; }
  double weight(std::size_t slot) const;

  /// N_eff = 1 / Σ w².
  double effective_sample_size() const;
  /// The particle with the highest weight; the first of equals.
  std::size_t best() const;

  /// Makes the weights sum up to 1.
  void normalize();
  /// Systematic resampling with `u` uniform in (0, 1): copies handles; weights become equal. Returns the ancestor of
  /// every slot.
  std::vector<int> resample(double u);
  /// Copies of all particles; maps as handles.
  std::vector<Particle> clone() const;
  void replace(std::vector<Particle>&& particles) { particles_ = std::move(particles); }

 private:
  void gather_weights();

  std::vector<Particle> particles_;
  std::vector<double> log_weights_;  // scratch
};

}  // namespace waymark::particles
