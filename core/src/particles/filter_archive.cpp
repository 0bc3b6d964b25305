// SPDX-License-Identifier: Apache-2.0
// State of the particles: copies for rollbacks, bytes for checkpoints.
#include <string>
#include <utility>

#include "estimation/belief_archive.hpp"
#include "particles/particle_filter.hpp"
#include "waymark/base/error.hpp"

namespace waymark::particles {

ParticleFilter::State ParticleFilter::state() const { return {set_.clone(), resamplings_, mapping_steps_}; }

void ParticleFilter::restore(const State& state) {
  for (std::size_t i = 0; i < set_.size(); ++i) set_[i] = state.particles[i].clone();
  resamplings_ = state.resamplings;
  mapping_steps_ = state.mapping_steps;
  recollection_.past().clear();
  mixture_is_current_ = false;
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
  if (count != set_.size()) {
    throw DataError("the checkpoint has " + std::to_string(count) + " particles, the configuration " +
                    std::to_string(set_.size()));
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
  recollection_.past().save(out);
  out.value(mixture_is_current_);
  if (mixture_is_current_) estimation::save_belief(mixture_, out);
}

void ParticleFilter::load(InArchive& in) {
  State state = load_state(in);
  set_.replace(std::move(state.particles));
  resamplings_ = state.resamplings;
  mapping_steps_ = state.mapping_steps;
  recollection_.past().load(in, set_.size(), layout());
  in.value(mixture_is_current_);  // after a mapping step it differs from the moments of the sampled particles
  if (mixture_is_current_) estimation::load_belief(mixture_, in, layout());
}

}  // namespace waymark::particles
