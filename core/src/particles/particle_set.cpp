// SPDX-License-Identifier: Apache-2.0
#include "particles/particle_set.hpp"

#include <cmath>
#include <utility>

#include "particles/resampling.hpp"

namespace waymark::particles {

double ParticleSet::weight(std::size_t slot) const { return std::exp(particles_[slot].log_weight); }

double ParticleSet::effective_sample_size() const {
  double sum = 0.0;
  for (const Particle& particle : particles_) sum += std::exp(2.0 * particle.log_weight);
  return 1.0 / sum;
}

std::size_t ParticleSet::best() const {
  std::size_t best = 0;
  for (std::size_t i = 1; i < particles_.size(); ++i) {
    if (particles_[i].log_weight > particles_[best].log_weight) best = i;
  }
  return best;
}

void ParticleSet::gather_weights() {
  for (std::size_t i = 0; i < particles_.size(); ++i) log_weights_[i] = particles_[i].log_weight;
}

void ParticleSet::normalize() {
  gather_weights();
  normalize_log_weights(log_weights_);
  for (std::size_t i = 0; i < particles_.size(); ++i) particles_[i].log_weight = log_weights_[i];
}

std::vector<int> ParticleSet::resample(double u) {
  gather_weights();
  std::vector<int> ancestors = systematic_resample(log_weights_, u);
  std::vector<Particle> next;
  next.reserve(particles_.size());
  for (std::size_t slot = 0; slot < ancestors.size(); ++slot) {
    const bool last_child = slot + 1 == ancestors.size() || ancestors[slot + 1] != ancestors[slot];
    Particle& parent = particles_[static_cast<std::size_t>(ancestors[slot])];
    next.push_back(last_child ? std::move(parent) : parent.clone());
    next.back().log_weight = -std::log(static_cast<double>(particles_.size()));
  }
  particles_ = std::move(next);
  return ancestors;
}

std::vector<Particle> ParticleSet::clone() const {
  std::vector<Particle> copy;
  copy.reserve(particles_.size());
  for (const Particle& particle : particles_) copy.push_back(particle.clone());
  return copy;
}

}  // namespace waymark::particles
