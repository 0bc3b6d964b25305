// SPDX-License-Identifier: Apache-2.0
#include "adaptive_noise.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace waymark::dgps {

void AdaptiveNoise::take(const Eigen::Vector2d& innovation, double prior_trace, double stated_trace, int rows) {
  const Taken before = std::exchange(last_, {innovation, prior_trace, stated_trace});
  if (!std::exchange(has_last_, true)) return;
  const auto slot = static_cast<std::size_t>(next_);
  const double prior = 0.5 * (prior_trace + before.prior_trace);
  const double stated = 0.5 * (stated_trace + before.stated_trace);
  const double expected = (prior + stated) / stated;
  ratios_[slot] = (0.5 * (innovation - before.innovation).squaredNorm() - prior) / stated;
  // χ² with `rows` degrees of freedom would be 2/rows; each innovation is in two differences, which makes it 3/2 as
  // much.
  variances_[slot] = 3.0 * expected * expected / rows;
  next_ = (next_ + 1) % window_;
  count_ = std::min(count_ + 1, window_);
  scale_ = 1.0;
  if (2 * count_ < window_) return;
  const double mean = std::accumulate(ratios_.begin(), ratios_.begin() + count_, 0.0) / count_;
  const double variance = std::accumulate(variances_.begin(), variances_.begin() + count_, 0.0) / (count_ * count_);
  if (mean > 1.0 + 3.0 * std::sqrt(variance)) scale_ = std::min(mean, kMaxScale);
}

}  // namespace waymark::dgps
