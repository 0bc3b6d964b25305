// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "waymark/archive.hpp"
#include "waymark/config.hpp"

namespace waymark::dgps {

/// How much larger than stated the noise is: the windowed mean of νᵀν − tr(H P Hᵀ) over what tr(R) of the stated noise
/// says (R. K. Mehra, IEEE Trans. Automatic Control 15(2), 1970; A. H. Mohamed, K. P. Schwarz, Journal of Geodesy 73,
/// 1999), within [1, 25]. What white noise as stated would give by chance (3σ of that mean) leaves it at 1.
class AdaptiveNoise {
 public:
  static constexpr int kMaxWindow = 64;
  static constexpr double kMaxScale = 25.0;

  /// `window`: innovations in the mean.
  explicit AdaptiveNoise(int window) : window_(window) {}

  /// One accepted innovation: its square, tr(H P Hᵀ), tr(R) as stated, and how many rows they are of.
  void take(double squared_innovation, double prior_trace, double stated_trace, int rows);
  double scale() const { return scale_; }  ///< of the stated variance

  void save(OutArchive& out) const;
  void load(InArchive& in);

 private:
  int window_;
  std::array<double, kMaxWindow> ratios_{};
  std::array<double, kMaxWindow> variances_{};  // of these ratios, if the noise is as stated
  int next_ = 0;
  int count_ = 0;
  double scale_ = 1.0;
};

}  // namespace waymark::dgps
