// SPDX-License-Identifier: Apache-2.0
// State of the particles: copies for rollbacks, bytes for checkpoints.
#include <string>
#include <utility>

#include "estimation/belief_archive.hpp"
#include "particles/particle_filter.hpp"
#include "waymark/base/error.hpp"
#include "waymark/interface/map_module.hpp"

namespace waymark::particles {

ParticleFilter::State ParticleFilter::state() const {
  return {set_.clone(), resamplings_, mapping_steps_, suspected_tears_, jumps_};
}

void ParticleFilter::restore(const State& state) {
  for (std::size_t i = 0; i < set_.size(); ++i) set_[i] = state.particles[i].clone();
  resamplings_ = state.resamplings;
  mapping_steps_ = state.mapping_steps;
  suspected_tears_ = state.suspected_tears;
  jumps_ = state.jumps;
  recollection_.past().clear();
  if (loops_) loops_->rewind(stamp());
  followed_ = {};
  redrawing_.reset();
  has_changed();
}

namespace {

constexpr double kMostLogWeight = 1e100;  // negative: of no weight at all
constexpr double kRounding = 1e-6;        // normalised weights are not above 1

/// A map that may be out of service, of the module that made it.
void serialize_map(OutArchive& out, const std::unique_ptr<ParticleMap>& map, const MapModule* /*module*/) {
  out.value(map != nullptr);
  if (map) map->save(out);
}
void serialize_map(InArchive& in, std::unique_ptr<ParticleMap>& map, const MapModule* module) {
  bool present = false;
  in.value(present);
  if (present && module == nullptr) throw DataError("the checkpoint has a map in service that the configuration lacks");
  map = present ? module->load_map(in) : nullptr;
}

}  // namespace

template <class Archive>
void ParticleFilter::serialize(Archive& archive, State& state) const {
  if (archive.section("particle_filter", 7) < 7) throw DataError("the checkpoint has an older version");
  std::uint64_t count = state.particles.size();
  archive(count);
  if (count != set_.size()) {
    throw DataError("the checkpoint has " + std::to_string(count) + " particles, the configuration " +
                    std::to_string(set_.size()));
  }
  archive(state.resamplings, state.mapping_steps, state.suspected_tears, state.jumps);
  state.particles.resize(set_.size());
  for (Particle& particle : state.particles) {
    estimation::serialize_belief(archive, particle.belief, layout());
    archive.within(particle.log_weight, -kMostLogWeight, kRounding);
    archive(particle.path, particle.T_map_mapped.p, particle.T_map_mapped.q);
    particle.anchors.serialize(archive,
                               [](auto& each, joint::AnchorPose& anchor) { each(anchor.anchor, anchor.xyyaw); });
    particle.maps.resize(modules_.size());
    for (std::size_t i = 0; i < modules_.size(); ++i) serialize_map(archive, particle.maps[i], modules_[i].get());
    if (particle.belief.stamp != state.particles.front().belief.stamp)
      throw DataError("the checkpoint has particles of different times");
  }
}
template void ParticleFilter::serialize(OutArchive& archive, State& state) const;
template void ParticleFilter::serialize(InArchive& archive, State& state) const;

/// The maps that are drawn again follow from the keyframes.
template <class Archive>
void ParticleFilter::serialize_redrawing(Archive& archive) {
  bool is_under_way = redrawing_.has_value();
  archive(is_under_way);
  if (!is_under_way) return;
  loops::Correction correction = redrawing_ ? redrawing_->correction() : loops::Correction{};
  std::uint64_t drawn = redrawing_ ? redrawing_->drawn() : 0;
  archive(correction.before, correction.way, correction.shift, drawn);
  ParticleMaps old(modules_.size());
  for (std::size_t i = 0; i < modules_.size(); ++i) {
    if (redrawing_ && redrawing_->old_maps()[i]) old[i] = redrawing_->old_maps()[i]->clone();
    serialize_map(archive, old[i], modules_[i].get());
  }
  if constexpr (Archive::kReads) {
    const std::span<const loops::Keyframe> keyframes = loops_->keyframes();
    if (correction.before.empty() || correction.before.size() > keyframes.size() || drawn > correction.before.size())
      throw DataError("the checkpoint has a correction that does not fit its path");
    redrawing_.emplace(std::move(correction), std::move(old), keyframes, drawn);
  }
}

template <class Archive>
void ParticleFilter::serialize_rest(Archive& archive) {
  recollection_.past().serialize(archive, set_.size(), layout(), stamp());
  bool is_joint = joint_.has_value();
  archive(is_joint);
  if constexpr (Archive::kReads) {
    if (is_joint && !joint_) throw DataError("the checkpoint has a joint Gaussian that the configuration lacks");
    if (!is_joint) joint_.reset();
  }
  if (joint_) archive(*joint_);
  if (joint_ && joint_->stamp() != stamp())
    throw DataError("the checkpoint has a joint Gaussian of another time than its particles");
  bool has_loops = loops_.has_value();
  archive(has_loops);
  if constexpr (Archive::kReads) {
    if (has_loops && !loops_) throw DataError("the checkpoint has loops that the configuration lacks");
    if (!has_loops) give_up_loops();
  }
  if (loops_) {
    loops_->serialize(archive, std::span<const std::shared_ptr<MapModule>>(modules_));
    serialize_redrawing(archive);
  }
  bool relocates = relocator_.has_value();
  archive(relocates);
  if constexpr (Archive::kReads) {
    if (relocates && !relocator_) throw DataError("the checkpoint has a search in a map that the configuration lacks");
    if (!relocates) relocator_.reset();
  }
  if (relocator_) archive(*relocator_, moved_);
  bool is_pending = !relocation_failure_.empty();
  archive(is_pending);
  if (!is_pending) relocation_failure_.clear();
  archive(mixture_is_current_);  // after a mapping step it is not what the sampled particles have
  if (!mixture_is_current_) return;
  estimation::serialize_belief(archive, mixture_, layout());
  if (mixture_.stamp != stamp()) throw DataError("the checkpoint has a mixture of another time than its particles");
}

void ParticleFilter::save(OutArchive& out) const {
  State now = state();
  serialize(out, now);
  // One list for both directions; writing changes nothing.
  const_cast<ParticleFilter&>(*this).serialize_rest(out);  // NOLINT(cppcoreguidelines-pro-type-const-cast)
}

void ParticleFilter::load(InArchive& in) {
  State now;
  serialize(in, now);
  set_.replace(std::move(now.particles));
  reported_is_current_ = false;
  resamplings_ = now.resamplings;
  mapping_steps_ = now.mapping_steps;
  suspected_tears_ = std::move(now.suspected_tears);
  jumps_ = now.jumps;
  followed_ = {};
  begin_relocation();
  serialize_rest(in);
}

}  // namespace waymark::particles
