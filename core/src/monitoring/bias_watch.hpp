// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Cholesky>
#include <algorithm>

#include "waymark/io/archive.hpp"
#include "waymark/math/gaussian.hpp"

namespace waymark::monitoring {

/// Detects biased innovations. Those of a belief that is as good as it says are white (T. Kailath,
/// IEEE Trans. Automatic Control 13(6), 1968), so their running mean is small; where it is not, the belief is off by
/// more than it knows (wheels slip), or the sensor is wrong, and each innovation alone may still pass its gate.
class BiasWatch {
 public:
  /// One accepted innovation and its covariance. True if the mean of the last ones cannot be chance.
  bool take(const gaussian::Vector& innovation, const gaussian::Matrix& S) {
    const Eigen::Index rows = std::min<Eigen::Index>(3, innovation.size());
    const Eigen::LLT<gaussian::Matrix> factor(S.topLeftCorner(rows, rows));
    gaussian::Vector white = innovation.head(rows);
    factor.matrixL().solveInPlace(white);
    count_ = std::min(count_ + 1.0, kWindow);
    const double share = 1.0 / count_;
    mean_.head(rows) += share * (innovation.head(rows) - mean_.head(rows));
    white_.head(rows) += share * (white - white_.head(rows));
    variance_ = (1.0 - share) * (1.0 - share) * variance_ + share * share;
    return count_ >= kFewest && white_.squaredNorm() > kNoChance * variance_;
  }
  /// Running mean of the innovations, as far as they have so many rows.
  const Eigen::Vector3d& mean() const { return mean_; }
  void restart() { *this = {}; }

  template <class Archive>
  void serialize(Archive& archive) {
    archive(count_, mean_, white_, variance_);
  }

 private:
  /// As many as the health looks at: few enough to see slipping wheels within seconds.
  static constexpr double kWindow = 20.0;
  static constexpr double kFewest = 5.0;
  /// χ² with two degrees of freedom exceeds it once in 3 · 10⁶ times; with three, in 7 · 10⁵.
  static constexpr double kNoChance = 30.0;

  double count_ = 0.0;
  Eigen::Vector3d mean_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d white_ = Eigen::Vector3d::Zero();  // running mean of the whitened ones
  double variance_ = 0.0;                            // of each row of that, if they are white
};

}  // namespace waymark::monitoring
