// SPDX-License-Identifier: Apache-2.0
#include "particles/recollection.hpp"

#include <functional>

#include "particles/update_step.hpp"

namespace waymark::particles {

Recollection::Recollection(const estimation::ProcessModel& process, const ParticleSet& particles,
                           MixtureMoments& moments, Workers& workers, Duration span)
    : process_(process),
      particles_(particles),
      moments_(moments),
      workers_(workers),
      past_(span),
      recalled_(particles.size()) {}

void Recollection::remember() {
  const Time now = particles_[0].belief.stamp;
  if (!past_.wants(now)) return;
  std::vector<Belief>& record = past_.add(now, particles_.size());
  for (std::size_t i = 0; i < particles_.size(); ++i) record[i] = particles_[i].belief;
}

bool Recollection::recall(Time stamp) {
  if (!past_.reach(stamp)) return false;
  past_.find(stamp, particles_.size(), beliefs_);
  const auto recall_one = [&](int slot) {
    const auto i = static_cast<std::size_t>(slot);
    recall(particles_[i].belief, *beliefs_[i], stamp, recalled_[i]);
  };
  workers_.for_each(static_cast<int>(particles_.size()), std::cref(recall_one), kSerialUpdates);
  for (std::size_t i = 0; i < particles_.size(); ++i) beliefs_[i] = &recalled_[i].past;
  moments_.compute(beliefs_, particles_, mixture_);
  return true;
}

/// Belief of one particle at `stamp`: predicted from the record before it. The information about the blocks since then
/// is carried back by one step of the Rauch–Tung–Striebel smoother (1965). Given the blocks, the past state and all
/// later measurements are taken as independent; for a sampled pose this follows from sampling.
void Recollection::recall(const Belief& now, const Belief& record, Time stamp, Recalled& out) const {
  const StateLayout& layout = process_.layout();
  Belief& recalled = out.past;
  recalled = record;
  process_.predict(recalled, stamp, false);
  const int blocks = layout.block_size();
  const int n = layout.size();
  const int first = layout.core_size();
  out.P_now_past.setZero(n, n);
  if (blocks == 0) return;

  out.predicted = recalled;
  process_.predict(out.predicted, now.stamp, false);
  const ErrorMatrix F = process_.transition(recalled.mean, to_seconds(now.stamp - stamp));
  const auto of_blocks = [&](const ErrorMatrix& M) { return M.block(first, first, blocks, blocks); };
  const Eigen::MatrixXd P_past_predicted = recalled.P.middleCols(first, blocks) * of_blocks(F).transpose();
  const Eigen::MatrixXd G = gaussian::divide(P_past_predicted, of_blocks(out.predicted.P));
  boxplus(recalled.mean, G * (now.mean.block - out.predicted.mean.block), layout);
  recalled.P += G * (of_blocks(now.P) - of_blocks(out.predicted.P)) * G.transpose();
  recalled.P = (0.5 * (recalled.P + recalled.P.transpose())).eval();
  out.P_now_past = now.P.middleCols(first, blocks) * G.transpose();
}

void Recollection::carry_gain(std::size_t slot, const estimation::StateJacobian& H,
                              estimation::ekf::Innovation& innovation) {
  innovation.PHt = estimation::ekf::project(recalled_[slot].P_now_past, H);
}

}  // namespace waymark::particles
