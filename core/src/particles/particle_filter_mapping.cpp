// SPDX-License-Identifier: Apache-2.0
// Mapping steps of the particle filter: refine, weigh and sample, insert, resample, with a barrier between.
#include <algorithm>
#include <cmath>
#include <exception>

#include "particles/particle_filter.hpp"
#include "waymark/base/error.hpp"

namespace waymark::particles {

namespace {

constexpr std::uint32_t kPriorDraw = 0x40000000;  // + sensor: what this random stream is for

}  // namespace

/// Lets every map refine `belief` in turn.
void ParticleFilter::refine(int slot, Belief& belief, std::span<const MappingInput> inputs, std::uint32_t sensor) {
  const Particle& particle = particles_[static_cast<std::size_t>(slot)];
  Scratch& scratch = scratch_[static_cast<std::size_t>(slot)];
  scratch.log_evidence = 0.0;
  scratch.writes = false;
  scratch.told = false;
  scratch.failed_input = -1;
  scratch.refinements.resize(modules_.size());  // each module meets its own association again, whoever else has inputs
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const MappingInput& input = inputs[i];
    const auto& map = particle.maps[static_cast<std::size_t>(input.module)];
    if (!map) continue;
    Refinement& refinement = scratch.refinements[static_cast<std::size_t>(input.module)];
    refinement.information.setZero();
    refinement.gradient.setZero();
    refinement.log_evidence = 0.0;
    refinement.writes = true;
    const PoseGaussian prior{belief.mean.T_map_base, pose_covariance(belief, layout())};
    Random stream = random(slot, kPriorDraw + sensor);
    const Eigen::Vector3d draw = gaussian::sample(prior.P, stream);
    Pose from = prior.T_map_base;
    from.p.head<2>() += draw.head<2>();
    from.q = (so3::exp({0.0, 0.0, draw.z()}) * from.q).normalized();
    try {
      map->refine(prior, from, *input.observation, refinement);
      if (!std::isfinite(refinement.log_evidence)) throw Error("the map's log evidence is not finite");
      scratch.writes = scratch.writes || refinement.writes;
      if (!input.localize) continue;
      if (!estimation::ekf::apply_pose_information(belief, layout(), input.share * refinement.information,
                                                   input.share * refinement.gradient)) {
        throw Error("the map's pose information is not finite");
      }
      scratch.log_evidence += input.share * refinement.log_evidence;
      scratch.told = scratch.told || !refinement.information.isZero(0.0);
    } catch (const std::exception& error) {
      scratch.failed_input = static_cast<int>(i);
      scratch.failure = error.what();
      return;
    } catch (...) {
      scratch.failed_input = static_cast<int>(i);
      scratch.failure = "unknown exception";
      return;
    }
  }
}

void ParticleFilter::insert(int slot, const Belief& belief, std::span<const MappingInput> inputs, std::size_t input) {
  Particle& particle = particles_[static_cast<std::size_t>(slot)];
  Scratch& scratch = scratch_[static_cast<std::size_t>(slot)];
  scratch.failed_input = -1;
  const auto module = static_cast<std::size_t>(inputs[input].module);
  const auto& map = particle.maps[module];
  if (!map) return;
  try {
    const PoseGaussian pose{belief.mean.T_map_base, pose_covariance(belief, layout())};
    map->insert(pose, *inputs[input].observation, scratch.refinements[module].association.get());
  } catch (const std::exception& error) {
    scratch.failed_input = static_cast<int>(input);
    scratch.failure = error.what();
  } catch (...) {
    scratch.failed_input = static_cast<int>(input);
    scratch.failure = "unknown exception";
  }
}

bool ParticleFilter::collect_failures(std::span<const MappingInput> inputs,
                                      std::vector<std::pair<int, std::string>>& failures) {
  bool any = false;
  for (Scratch& scratch : scratch_) {
    if (scratch.failed_input < 0) continue;
    const int input = scratch.failed_input;
    any = true;
    if (std::none_of(failures.begin(), failures.end(), [&](const auto& f) { return f.first == input; })) {
      failures.emplace_back(input, scratch.failure);
      drop_module(inputs[static_cast<std::size_t>(input)].module);
    }
  }
  return any;
}

/// Reads the maps. A module that throws for one particle loses its part for all, or the weights were not comparable.
/// `late`: for the recalled beliefs.
void ParticleFilter::refine_all(std::span<const MappingInput> inputs, std::uint32_t sensor, bool late,
                                std::vector<std::pair<int, std::string>>& failures) {
  const int count = static_cast<int>(particles_.size());
  const auto belief = [&](std::size_t i) -> Belief& { return late ? scratch_[i].recalled : particles_[i].belief; };
  for (std::size_t i = 0; i < particles_.size(); ++i) scratch_[i].prior = belief(i);
  const auto refine_each = [&] {
    workers_.for_each(
        count, [&](int slot) { refine(slot, belief(static_cast<std::size_t>(slot)), inputs, sensor); }, 2);
  };
  refine_each();
  while (collect_failures(inputs, failures)) {
    // All are restored before any is refined: the random streams read the first one's stamp.
    for (std::size_t i = 0; i < particles_.size(); ++i) belief(i) = scratch_[i].prior;
    refine_each();
  }
  for (std::size_t i = 0; i < particles_.size(); ++i) particles_[i].log_weight += scratch_[i].log_evidence;
  located_ = 2 * std::ranges::count_if(scratch_, &Scratch::told) >= count;
  normalize();
}

/// Each particle writes its own maps. One module after the other, so that one that throws keeps no other from writing.
void ParticleFilter::insert_all(std::span<const MappingInput> inputs, bool late,
                                std::vector<std::pair<int, std::string>>& failures) {
  for (std::size_t input = 0; input < inputs.size(); ++input) {
    workers_.for_each(
        static_cast<int>(particles_.size()),
        [&](int slot) {
          const auto i = static_cast<std::size_t>(slot);
          insert(slot, late ? scratch_[i].recalled : particles_[i].belief, inputs, input);
        },
        2);
    collect_failures(inputs, failures);
  }
}

std::vector<std::pair<int, std::string>> ParticleFilter::map(std::span<const MappingInput> inputs,
                                                             std::uint32_t sensor) {
  std::vector<std::pair<int, std::string>> failures;
  // 1. Refine; the evidence goes into the weights in slot order.
  refine_all(inputs, sensor, false, failures);

  // 2. Sample; the moments of the refined mixture are what is reported.
  compute_mixture();
  workers_.for_each(
      static_cast<int>(particles_.size()),
      [&](int slot) {
        if (!scratch_[static_cast<std::size_t>(slot)].writes) return;
        Random stream = random(slot, sensor);
        estimation::ekf::sample_pose(particles_[static_cast<std::size_t>(slot)].belief, layout(),
                                     settings_.sampling_fraction, stream);
      },
      kSerialUpdates);

  // 3. Insert.
  insert_all(inputs, false, failures);
  for (std::size_t i = 0; i < particles_.size(); ++i)
    particles_[i].path.settle(scratch_[i].prior.mean.T_map_base, particles_[i].belief.mean.T_map_base);
  record_path();
  ++mapping_steps_;

  // 4. Resample: one thread copies handles.
  const Belief reported = mixture_;
  resample_if_needed(sensor);
  mixture_ = reported;
  mixture_valid_ = true;
  return failures;
}

std::vector<std::pair<int, std::string>> ParticleFilter::map_late(std::span<const MappingInput> inputs,
                                                                  std::uint32_t sensor) {
  std::vector<std::pair<int, std::string>> failures;
  refine_all(inputs, sensor, true, failures);
  insert_all(inputs, true, failures);
  ++mapping_steps_;
  return failures;
}

}  // namespace waymark::particles
