// SPDX-License-Identifier: Apache-2.0
// What the particles are, as a copy to go back to and as bytes on a checkpoint.
#include <string>

#include "estimation/belief_archive.hpp"
#include "particles/particle_filter.hpp"
#include "waymark/base/error.hpp"

namespace waymark::particles {

Particle Particle::clone() const {
  Particle copy{belief, log_weight, {}, path};
  copy.maps.reserve(maps.size());
  for (const auto& map : maps) copy.maps.push_back(map ? map->clone() : nullptr);
  return copy;
}

ParticleFilter::State ParticleFilter::state() const {
  State state;
  state.particles.reserve(particles_.size());
  for (const Particle& particle : particles_) state.particles.push_back(particle.clone());
  state.resamplings = resamplings_;
  state.mapping_steps = mapping_steps_;
  return state;
}

void ParticleFilter::restore(const State& state) {
  for (std::size_t i = 0; i < particles_.size(); ++i) particles_[i] = state.particles[i].clone();
  resamplings_ = state.resamplings;
  mapping_steps_ = state.mapping_steps;
  past_.clear();
  mixture_valid_ = false;
}

void ParticleFilter::save(const State& state, OutArchive& out) const {
  out.section("particle_filter", 2);
  out.value(static_cast<std::uint64_t>(state.particles.size()));
  out.value(state.resamplings);
  out.value(state.mapping_steps);
  for (const Particle& particle : state.particles) {
    estimation::save_belief(particle.belief, out);
    out.value(particle.log_weight);
    particle.path.save(out);
    for (const auto& map : particle.maps) {
      out.value(map != nullptr);
      if (map) map->save(out);
    }
  }
}

ParticleFilter::State ParticleFilter::load_state(InArchive& in) const {
  in.section("particle_filter", 2);
  std::uint64_t count = 0;
  in.value(count);
  if (count != particles_.size()) {
    throw DataError("the checkpoint has " + std::to_string(count) + " particles, the configuration " +
                    std::to_string(particles_.size()));
  }
  State state;
  in.value(state.resamplings);
  in.value(state.mapping_steps);
  for (std::uint64_t i = 0; i < count; ++i) {
    Particle& particle = state.particles.emplace_back();
    estimation::load_belief(particle.belief, in, layout());
    in.value(particle.log_weight);
    particle.path.load(in);
    for (const auto& module : modules_) {
      bool present = false;
      in.value(present);
      if (present && !module) throw DataError("the checkpoint has a map in service that the configuration lacks");
      particle.maps.push_back(present ? module->load_map(in) : nullptr);
    }
  }
  return state;
}

void ParticleFilter::save(OutArchive& out) const {
  save(state(), out);
  past_.save(out);
  out.value(mixture_valid_);
  if (mixture_valid_) estimation::save_belief(mixture_, out);
}

void ParticleFilter::load(InArchive& in) {
  State state = load_state(in);
  particles_ = std::move(state.particles);
  resamplings_ = state.resamplings;
  mapping_steps_ = state.mapping_steps;
  past_.load(in, particles_.size(), layout());
  in.value(mixture_valid_);  // after a mapping step it is not what the sampled particles have
  if (mixture_valid_) estimation::load_belief(mixture_, in, layout());
}

}  // namespace waymark::particles
