// SPDX-License-Identifier: Apache-2.0
// The robot in a loaded map, where it may not be where the particles have it.
#include "loops/planar.hpp"
#include "particles/particle_filter.hpp"
#include "waymark/base/error.hpp"
#include "waymark/interface/map_module.hpp"

namespace waymark::particles {

void ParticleFilter::begin_relocation() {
  relocator_.reset();
  searched_module_ = -1;
  if (!settings_.relocation.enabled) return;
  for (std::size_t i = 0; i < modules_.size(); ++i) {
    // A map of three dimensions shows a slice, which need not be what its observations hold.
    if (!modules_[i] || !modules_[i]->has_prior_map() || !modules_[i]->can_draw_again()) continue;
    try {
      std::optional<GridView> map = modules_[i]->create_map()->grid();
      if (!map) continue;
      relocator_.emplace(std::move(*map));
      searched_module_ = static_cast<int>(i);
    } catch (const std::exception& error) {
      relocation_failure_ = error.what();
    }
    return;
  }
}

void ParticleFilter::begin_way() {
  for (Particle& particle : set_) particle.T_map_mapped = particle.belief.mean.T_map_base;
  place_.reset();
  moved_.setZero();
  if (relocator_) relocator_->begin_anew();
}

relocation::Placement ParticleFilter::placement() const {
  return relocator_ ? relocator_->placement() : relocation::Placement::fits;
}

void ParticleFilter::relocate(std::span<const MappingInput> inputs, std::size_t slot, MappingFailures& failures) {
  const Particle& particle = set_[slot];
  moved_ = loops::compose(moved_, loops::between(loops::planar(particle.T_map_mapped),
                                                 loops::planar(mapping_.prior(slot).mean.T_map_base)));
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const MappingInput& input = inputs[i];
    if (input.module != searched_module_ || !input.localize) continue;
    correspondences_.landmarks.clear();
    correspondences_.points_base.clear();
    if (!correspond(inputs, i, slot, failures) || correspondences_.points_base.empty()) return;
    const std::vector<Eigen::Vector2f> points = loops::thinned(correspondences_.points_base);
    place_ = relocator_->add({moved_, loops::planar(particle.belief.mean.T_map_base), points,
                              mapping_.refinement(slot, input.module).writes});
    moved_.setZero();
    return;
  }
}

}  // namespace waymark::particles
