// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <string>

#include "waymark/base/error.hpp"
#include "waymark/config/config.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::dgps {

/// How much larger than stated the noise is: the windowed mean of ½|ν_k − ν_{k−1}|² − tr(H P Hᵀ) over what tr(R) of the
/// stated noise claims, within [1, 25]. What white noise as stated would give by chance (3σ of that mean) leaves it
/// at 1. Matching the innovations' covariance is R. K. Mehra's (IEEE Trans. Automatic Control 15(2), 1970), in a window
/// A. H. Mohamed's and K. P. Schwarz's (Journal of Geodesy 73, 1999); they take νᵀν, but innovations that all point to
/// one side are not noise of the fixes: wheels slip, or the belief is off. Successive differences do not see them (J.
/// von Neumann et al., Ann. Math. Statistics 12(2), 1941).
class AdaptiveNoise {
 public:
  static constexpr int kMaxWindow = 64;
  static constexpr double kMaxScale = 25.0;

  /// `window`: innovations in the mean.
  explicit AdaptiveNoise(int window) : window_(window) {}

  /// One accepted innovation of `rows` rows (the others 0), tr(H P Hᵀ), and tr(R) as stated.
  void take(const Eigen::Vector2d& innovation, double prior_trace, double stated_trace, int rows);
  /// The next innovation does not follow on the last one.
  void interrupt() { has_last_ = false; }
  double scale() const { return scale_; }  ///< of the stated variance

  template <class Archive>
  void serialize(Archive& archive) {
    if (archive.section("adaptive_noise", 2) < 2)
      throw DataError("adaptive noise: the checkpoint has an older version");
    int window = window_;
    archive(window);
    if (window != window_) throw DataError("adaptive noise: the checkpoint has a window of " + std::to_string(window));
    archive(has_last_, last_);
    for (int i = 0; i < window_; ++i)
      archive(ratios_[static_cast<std::size_t>(i)], variances_[static_cast<std::size_t>(i)]);
    archive.within(next_, 0, window_ - 1);
    archive.within(count_, 0, window_);
    archive.within(scale_, 1.0, kMaxScale);
  }

 private:
  struct Taken {
    Eigen::Vector2d innovation = Eigen::Vector2d::Zero();
    double prior_trace = 0.0;
    double stated_trace = 0.0;

    template <class Archive>
    void serialize(Archive& archive) {
      archive(innovation, prior_trace, stated_trace);
    }
  };

  int window_;
  Taken last_;
  bool has_last_ = false;
  std::array<double, kMaxWindow> ratios_{};
  std::array<double, kMaxWindow> variances_{};  // of these ratios, if the noise is as stated
  int next_ = 0;
  int count_ = 0;
  double scale_ = 1.0;
};

}  // namespace waymark::dgps
