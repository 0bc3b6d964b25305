// SPDX-License-Identifier: Apache-2.0
#include "adaptive_noise.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "waymark/error.hpp"

namespace waymark::dgps {

void AdaptiveNoise::take(double squared_innovation, double prior_trace, double stated_trace, int rows) {
  const auto slot = static_cast<std::size_t>(next_);
  const double expected = (prior_trace + stated_trace) / stated_trace;
  ratios_[slot] = (squared_innovation - prior_trace) / stated_trace;
  variances_[slot] = 2.0 * expected * expected / rows;  // χ² with `rows` degrees of freedom
  next_ = (next_ + 1) % window_;
  count_ = std::min(count_ + 1, window_);
  scale_ = 1.0;
  if (2 * count_ < window_) return;
  const double mean = std::accumulate(ratios_.begin(), ratios_.begin() + count_, 0.0) / count_;
  const double variance = std::accumulate(variances_.begin(), variances_.begin() + count_, 0.0) / (count_ * count_);
  if (mean > 1.0 + 3.0 * std::sqrt(variance)) scale_ = std::min(mean, kMaxScale);
}

void AdaptiveNoise::save(OutArchive& out) const {
  out.section("adaptive_noise", 1);
  out.value(window_);
  for (int i = 0; i < window_; ++i) {
    out.value(ratios_[static_cast<std::size_t>(i)]);
    out.value(variances_[static_cast<std::size_t>(i)]);
  }
  out.value(next_);
  out.value(count_);
  out.value(scale_);
}

void AdaptiveNoise::load(InArchive& in) {
  in.section("adaptive_noise", 1);
  int window = 0;
  in.value(window);
  if (window != window_) throw DataError("adaptive noise: the checkpoint has a window of " + std::to_string(window));
  for (int i = 0; i < window_; ++i) {
    in.value(ratios_[static_cast<std::size_t>(i)]);
    in.value(variances_[static_cast<std::size_t>(i)]);
  }
  in.value(next_);
  in.value(count_);
  in.value(scale_);
}

}  // namespace waymark::dgps
