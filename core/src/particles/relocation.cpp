// SPDX-License-Identifier: Apache-2.0
// The robot in a loaded map, where it may not be where the particles have it.
#include "loops/planar.hpp"
#include "particles/particle_filter.hpp"
#include "waymark/base/error.hpp"

namespace waymark::particles {

void ParticleFilter::begin_relocation() {
  relocator_.reset();
  searched_module_ = -1;
  // Absolute sensors find a robot without a search.
  if (!settings_.relocation.enabled || georeference_) return;
  for (std::size_t i = 0; i < modules_.size(); ++i) {
    if (!modules_[i] || !modules_[i]->has_prior_map()) continue;
    std::optional<GridView> map = modules_[i]->create_map()->grid();
    if (!map) continue;
    try {
      relocator_.emplace(std::move(*map));
      searched_module_ = static_cast<int>(i);
    } catch (const Error& error) {
      relocation_failure_ = error.what();
    }
    return;
  }
}

monitoring::Placement ParticleFilter::placement() const {
  using enum monitoring::Placement;
  if (!relocator_) return fits;
  if (relocator_->is_lost()) return relocator_->is_ambiguous() ? ambiguous : misplaced;
  return relocator_->is_doubtful() ? doubtful : fits;
}

void ParticleFilter::relocate(std::span<const MappingInput> inputs, std::size_t slot, const Pose& predicted) {
  const Particle& particle = set_[slot];
  correspondences_.landmarks.clear();
  correspondences_.points_base.clear();
  for (const MappingInput& input : inputs) {
    if (input.module != searched_module_) continue;
    const auto& map = particle.maps[static_cast<std::size_t>(input.module)];
    if (map)
      map->correspond(*input.observation, mapping_.refinement(slot, input.module).association.get(), correspondences_);
  }
  if (correspondences_.points_base.empty()) return;
  const std::vector<Eigen::Vector2f> points = loops::thinned(correspondences_.points_base);
  place_ = relocator_->add({loops::between(loops::planar(last_), loops::planar(predicted)),
                            loops::planar(particle.belief.mean.T_map_base), points, mapping_.writes(slot)});
}

}  // namespace waymark::particles
