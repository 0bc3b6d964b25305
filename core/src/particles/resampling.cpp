// SPDX-License-Identifier: Apache-2.0
#include "particles/resampling.hpp"

#include <cmath>
#include <limits>

#include "waymark/math/gaussian.hpp"

namespace waymark::particles {

bool normalize_log_weights(std::span<double> log_weights) {
  const double sum = gaussian::log_sum_exp(log_weights.data(), static_cast<int>(log_weights.size()));
  if (!std::isfinite(sum)) {
    for (double& w : log_weights) w = -std::log(static_cast<double>(log_weights.size()));
    return false;
  }
  for (double& w : log_weights) w -= sum;
  return true;
}

double effective_sample_size(std::span<const double> log_weights) {
  double sum = 0.0;
  for (const double w : log_weights) sum += std::exp(2.0 * w);
  return 1.0 / sum;
}

std::vector<int> systematic_resample(std::span<const double> log_weights, double u) {
  const std::size_t count = log_weights.size();
  std::vector<int> ancestors(count);
  // Rounding may leave the sum below the last threshold: the remainder belongs to the last particle with a weight above
  // zero.
  std::size_t last = count - 1;
  while (last > 0 && std::exp(log_weights[last]) == 0.0) --last;
  double cumulative = std::exp(log_weights[0]);
  std::size_t parent = 0;
  for (std::size_t slot = 0; slot < count; ++slot) {
    const double threshold = (static_cast<double>(slot) + u) / static_cast<double>(count);
    while (cumulative < threshold && parent < last) cumulative += std::exp(log_weights[++parent]);
    ancestors[slot] = static_cast<int>(parent);
  }
  return ancestors;
}

}  // namespace waymark::particles
