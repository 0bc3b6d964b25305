// SPDX-License-Identifier: Apache-2.0
#include "latency.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace waymark::host {
namespace {

constexpr double kSmallest = 1e-6;  // upper edge of the first bin [s]
constexpr double kRatio = 1.05;

}  // namespace

void Latency::add(double seconds) {
  const double bin = seconds <= kSmallest ? 0.0 : std::ceil(std::log(seconds / kSmallest) / std::log(kRatio));
  ++bins_[static_cast<std::size_t>(std::min(bin, static_cast<double>(kBins - 1)))];
  ++count_;
  max_ = std::max(max_, seconds);
}

double Latency::quantile(double share) const {
  if (count_ == 0) return 0.0;
  const double rank = share * static_cast<double>(count_);
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < kBins; ++i) {
    sum += bins_[i];
    if (static_cast<double>(sum) >= rank) return std::min(max_, kSmallest * std::pow(kRatio, static_cast<double>(i)));
  }
  return max_;
}

}  // namespace waymark::host
