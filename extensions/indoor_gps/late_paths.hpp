// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace waymark::indoor_gps {

/// What the innovation of a range says, if its noise is not Gaussian: a Gaussian innovation and noise with which a
/// Kalman update has the mean and the variance of the true posterior.
struct EquivalentInnovation {
  double nu;        ///< [m]
  double variance;  ///< of the innovation: prior and noise [m²]
};

/// Noise of ranges by radio. With probability 1 − share the first path is the straight one; otherwise it is longer by
/// an exponentially distributed excess (non-line-of-sight), which makes a heavy tail on the positive side only. A
/// difference of ranges has such a tail on both sides, since its reference can be late, too.
class LatePaths {
 public:
  /// `share` in [0, 1), `mean_excess` > 0 [m].
  LatePaths(double share, double mean_excess) : share_(share), mean_excess_(mean_excess) {}

  /// By the score of the innovation's density (C. J. Masreliez, "Approximate non-Gaussian filtering with linear state
  /// and observation relations", IEEE Transactions on Automatic Control 20(1), 1975): the posterior's mean is P Hᵀ g
  /// and its covariance P − P Hᵀ G H P, with g = −d log f/dν and G = dg/dν; so ν' = g/G, and its variance is 1/G. Where
  /// 1/G grows without bound the variance is the one at which the NIS is 4; the mean is exact throughout. `variance`:
  /// of the innovation without any excess, H P Hᵀ + σ² [m²].
  EquivalentInnovation equivalent(double nu, double variance, bool is_difference) const;

 private:
  double share_;
  double mean_excess_;
};

}  // namespace waymark::indoor_gps
