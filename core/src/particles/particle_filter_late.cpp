// SPDX-License-Identifier: Apache-2.0
// Late measurements in the particle filter (estimation.md §2, "Order"): sampled paths and maps stay, the weights and
// the blocks that are Gaussian given the path take what the measurement says.
#include "particles/particle_filter.hpp"

namespace waymark::particles {

void ParticleFilter::remember() {
  if (!past_.wants(stamp())) return;
  std::vector<Belief>& record = past_.add(stamp(), particles_.size());
  for (std::size_t i = 0; i < particles_.size(); ++i) record[i] = particles_[i].belief;
}

bool ParticleFilter::recall(Time stamp) {
  if (!past_.reach(stamp)) return false;
  past_.find(stamp, particles_.size(), beliefs_);
  workers_.for_each(
      static_cast<int>(particles_.size()),
      [&](int slot) { recall(slot, *beliefs_[static_cast<std::size_t>(slot)], stamp); }, kSerialUpdates);
  for (std::size_t i = 0; i < particles_.size(); ++i) beliefs_[i] = &scratch_[i].recalled;
  compute_moments(beliefs_, recalled_mixture_);
  return true;
}

/// What one particle believes of `stamp`: predicted there from the record before. What has been learnt of the blocks
/// since then is carried back by one step of the Rauch–Tung–Striebel smoother (1965). Given the blocks the state then
/// and all that came since are taken as independent: for the pose that is what sampling it means.
void ParticleFilter::recall(int slot, const Belief& record, Time stamp) {
  const Belief& now = particles_[static_cast<std::size_t>(slot)].belief;
  Scratch& scratch = scratch_[static_cast<std::size_t>(slot)];
  Belief& then = scratch.recalled;
  then = record;
  process_.predict(then, stamp, false);
  const int blocks = layout().block_size();
  const int n = layout().size();
  const int first = layout().core_size();
  scratch.now_and_then.setZero(n, n);
  if (blocks == 0) return;

  scratch.prior = then;  // to be predicted to now, with nothing learnt in between
  process_.predict(scratch.prior, now.stamp, false);
  const ErrorMatrix F = process_.transition(then.mean, to_seconds(now.stamp - stamp));
  const auto of_blocks = [&](const ErrorMatrix& M) { return M.block(first, first, blocks, blocks); };
  const Eigen::MatrixXd then_and_prior = then.P.middleCols(first, blocks) * of_blocks(F).transpose();
  const Eigen::MatrixXd G = gaussian::divide(then_and_prior, of_blocks(scratch.prior.P));
  boxplus(then.mean, G * (now.mean.block - scratch.prior.mean.block), layout());
  then.P += G * (of_blocks(now.P) - of_blocks(scratch.prior.P)) * G.transpose();
  then.P = (0.5 * (then.P + then.P.transpose())).eval();
  scratch.now_and_then = now.P.middleCols(first, blocks) * G.transpose();
}

MixtureOutcome ParticleFilter::update_late(const Update& model, const UpdatePolicy& policy) {
  workers_.for_each(
      static_cast<int>(particles_.size()),
      [&](int slot) { innovate(slot, scratch_[static_cast<std::size_t>(slot)].recalled, model, policy, true); },
      kSerialUpdates);
  return weigh_and_apply(policy);
}

}  // namespace waymark::particles
