// SPDX-License-Identifier: Apache-2.0
#include "estimation/past_belief.hpp"

#include "waymark/math/gaussian.hpp"

namespace waymark::estimation {

void PastBelief::compute(const ProcessModel& process, const Belief& now, const Belief& record, Time stamp) {
  const StateLayout& layout = process.layout();
  past = record;
  process.predict(past, stamp, false);
  const int blocks = layout.block_size();
  const int n = layout.size();
  const int first = layout.core_size();
  P_now_past.setZero(n, n);
  if (blocks == 0) return;

  predicted = past;
  process.predict(predicted, now.stamp, false);
  const ErrorMatrix F = process.transition(past.mean, to_seconds(now.stamp - stamp));
  const auto of_blocks = [&](const ErrorMatrix& M) { return M.block(first, first, blocks, blocks); };
  const Eigen::MatrixXd P_past_predicted = past.P.middleCols(first, blocks) * of_blocks(F).transpose();
  const Eigen::MatrixXd G = gaussian::divide(P_past_predicted, of_blocks(predicted.P));
  boxplus(past.mean, G * (now.mean.block - predicted.mean.block), layout);
  past.P += G * (of_blocks(now.P) - of_blocks(predicted.P)) * G.transpose();
  past.P = (0.5 * (past.P + past.P.transpose())).eval();
  P_now_past = now.P.middleCols(first, blocks) * G.transpose();
}

}  // namespace waymark::estimation
