// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace waymark::host {

/// Quantiles of latencies in bounded memory: a histogram with bins of 5 %.
class Latency {
 public:
  void add(double seconds);
  /// Upper edge of the bin that contains the quantile [s]; 0 without any.
  double quantile(double share) const;
  double max() const { return max_; }
  std::uint64_t count() const { return count_; }

 private:
  static constexpr std::size_t kBins = 400;
  std::array<std::uint64_t, kBins> bins_{};
  std::uint64_t count_ = 0;
  double max_ = 0.0;
};

}  // namespace waymark::host
