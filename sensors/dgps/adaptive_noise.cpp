// SPDX-License-Identifier: Apache-2.0
#include "adaptive_noise.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "waymark/base/error.hpp"

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

void AdaptiveNoise::save(OutArchive& out) const {
  out.section("adaptive_noise", 2);
  out.value(window_);
  out.value(has_last_);
  out.value(last_.innovation);
  out.value(last_.prior_trace);
  out.value(last_.stated_trace);
  for (int i = 0; i < window_; ++i) {
    out.value(ratios_[static_cast<std::size_t>(i)]);
    out.value(variances_[static_cast<std::size_t>(i)]);
  }
  out.value(next_);
  out.value(count_);
  out.value(scale_);
}

void AdaptiveNoise::load(InArchive& in) {
  if (in.section("adaptive_noise", 2) < 2) throw DataError("adaptive noise: the checkpoint is of an older kind");
  int window = 0;
  in.value(window);
  if (window != window_) throw DataError("adaptive noise: the checkpoint has a window of " + std::to_string(window));
  in.value(has_last_);
  in.value(last_.innovation);
  in.value(last_.prior_trace);
  in.value(last_.stated_trace);
  for (int i = 0; i < window_; ++i) {
    in.value(ratios_[static_cast<std::size_t>(i)]);
    in.value(variances_[static_cast<std::size_t>(i)]);
  }
  in.value(next_);
  in.value(count_);
  in.value(scale_);
}

}  // namespace waymark::dgps
