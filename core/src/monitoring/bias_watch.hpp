// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Cholesky>
#include <algorithm>

#include "waymark/io/archive.hpp"
#include "waymark/math/gaussian.hpp"

namespace waymark::monitoring {

/// Detects biased innovations. The innovations of a consistent filter are white (T. Kailath, IEEE Trans. Automatic
/// Control 13(6), 1968), so their running mean is small. If it is not, the belief is overconfident (wheels slip) or the
/// sensor is biased, although each innovation may pass its gate.
class BiasWatch {
 public:
  /// Adds one accepted innovation with its covariance. True if the running mean is too large for chance.
  bool add(const gaussian::Vector& innovation, const gaussian::Matrix& S) {
    const Eigen::Index rows = std::min<Eigen::Index>(3, innovation.size());
    const Eigen::LLT<gaussian::Matrix> factor(S.topLeftCorner(rows, rows));
    gaussian::Vector white = innovation.head(rows);
    factor.matrixL().solveInPlace(white);
    count_ = std::min(count_ + 1.0, kWindow);
    const double share = 1.0 / count_;
    mean_.head(rows) += share * (innovation.head(rows) - mean_.head(rows));
    white_.head(rows) += share * (white - white_.head(rows));
    variance_ = (1.0 - share) * (1.0 - share) * variance_ + share * share;
    return count_ >= kMinCount && white_.squaredNorm() > kThreshold * variance_;
  }
  /// Running mean of the innovations, of at most three rows; 0 for missing rows.
  const Eigen::Vector3d& mean() const { return mean_; }
  void reset() { *this = {}; }

  template <class Archive>
  void serialize(Archive& archive) {
    archive.within(count_, 0.0, kWindow);
    archive(mean_, white_, variance_);
  }

 private:
  /// The window of the health monitor: short enough to detect slipping wheels within seconds.
  static constexpr double kWindow = 20.0;
  static constexpr double kMinCount = 5.0;
  /// χ² with two degrees of freedom exceeds it with probability 3 · 10⁻⁷, with three 1.4 · 10⁻⁶.
  static constexpr double kThreshold = 30.0;

  double count_ = 0.0;
  Eigen::Vector3d mean_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d white_ = Eigen::Vector3d::Zero();  // running mean of the whitened ones
  double variance_ = 0.0;                            // of each row of that, if they are white
};

}  // namespace waymark::monitoring
