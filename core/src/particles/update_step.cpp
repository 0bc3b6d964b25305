// SPDX-License-Identifier: Apache-2.0
#include "particles/update_step.hpp"

#include <algorithm>
#include <exception>
#include <functional>

#include "waymark/base/error.hpp"

namespace waymark::particles {

namespace ekf = estimation::ekf;

UpdateStep::UpdateStep(const StateLayout& layout, const std::optional<estimation::Georeference>& georeference,
                       Workers& workers, std::size_t particles)
    : layout_(layout), georeference_(georeference), workers_(workers), scratch_(particles) {}

MixtureOutcome UpdateStep::apply(ParticleSet& particles, Instant& at, const Update& model, const UpdatePolicy& policy) {
  const int count = static_cast<int>(particles.size());
  const auto innovate_one = [&](int slot) { innovate(static_cast<std::size_t>(slot), at, model, policy); };
  workers_.for_each(count, std::cref(innovate_one), kSerialUpdates);

  MixtureOutcome outcome = gate(particles, policy);
  if (!outcome.usable || policy.evaluate_only) return outcome;

  const auto update_one = [&](int slot) {
    const auto i = static_cast<std::size_t>(slot);
    update(particles[i], scratch_[i].innovation, outcome.accepted, policy);
  };
  workers_.for_each(count, std::cref(update_one), kSerialUpdates);
  return outcome;
}

void UpdateStep::innovate(std::size_t slot, Instant& at, const Update& model, const UpdatePolicy& policy) {
  const Belief& belief = at.belief(slot);
  const int block_offset = layout_.block_offset(policy.owner);
  Scratch& scratch = scratch_[slot];
  scratch.failure.reset();
  try {
    const bool in_enu = georeference_ && policy.absolute;
    if (in_enu) scratch.enu = georeference_->in_enu(belief.mean);
    const NavState& state = in_enu ? scratch.enu : belief.mean;
    model.linearize({state, state.block.data() + block_offset}, scratch.model);
    scratch.H.reset(scratch.model.rows(), layout_.size());
    if (in_enu) {
      georeference_->scatter(belief.mean, block_offset, scratch.model, scratch.H);
    } else {
      estimation::scatter(layout_, block_offset, scratch.model, scratch.H);
    }
    ekf::innovate(belief, scratch.model, scratch.H, scratch.innovation);
    if (!policy.evaluate_only) at.carry_gain(slot, scratch.H, scratch.innovation);
  } catch (const std::exception& error) {
    scratch.failure = error.what();
  } catch (...) {
    scratch.failure = "unknown exception";
  }
}

MixtureOutcome UpdateStep::gate(const ParticleSet& particles, const UpdatePolicy& policy) const {
  MixtureOutcome outcome;
  for (const Scratch& scratch : scratch_) {
    if (scratch.failure) throw Error(*scratch.failure);
    outcome.usable = outcome.usable && scratch.innovation.finite;
  }
  if (!outcome.usable) return outcome;

  outcome.observes_speed = estimation::observes_speed(scratch_.front().model);
  const ekf::Innovation& first = scratch_.front().innovation;
  const int rows = static_cast<int>(first.nu.size());
  if (particles.size() == 1) {  // the mixture is its only Gaussian
    outcome.innovation = first.nu;
    outcome.S = first.S;
    outcome.nis = first.density.squared_mahalanobis;
  } else {
    outcome.innovation.setZero(rows);
    outcome.S.setZero(rows, rows);
    for (std::size_t i = 0; i < particles.size(); ++i) {
      outcome.innovation += particles.weight(i) * scratch_[i].innovation.nu;
    }
    for (std::size_t i = 0; i < particles.size(); ++i) {
      const gaussian::Vector spread = scratch_[i].innovation.nu - outcome.innovation;
      outcome.S += particles.weight(i) * (scratch_[i].innovation.S + spread * spread.transpose());
    }
    outcome.nis = gaussian::density(outcome.innovation, outcome.S).squared_mahalanobis;
  }
  outcome.accepted = policy.ignore_gate || outcome.nis <= policy.gates[rows];
  return outcome;
}

/// A gated update counts in the weight with its likelihood clamped at the gate.
void UpdateStep::update(Particle& particle, const ekf::Innovation& innovation, bool accepted,
                        const UpdatePolicy& policy) const {
  double log_evidence = innovation.density.log_density;
  if (accepted) {
    ekf::apply(particle.belief, layout_, innovation);
  } else {
    const double nis = innovation.density.squared_mahalanobis;
    log_evidence += 0.5 * (nis - std::min(nis, policy.gates[static_cast<int>(innovation.nu.size())]));
  }
  particle.log_weight += policy.weight_exponent * log_evidence;
}

}  // namespace waymark::particles
