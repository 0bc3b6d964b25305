// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace waymark::gnss {

/// A value and a variance: of an innovation, or of noise [m, m²].
struct Moments {
  double mean;
  double variance;
};

/// Noise of a pseudorange among houses: with probability 1 − share it is Gaussian; otherwise the signal came by a
/// reflection, and is longer by an exponentially distributed excess.
struct LateSignal {
  double variance;     ///< of the Gaussian part, σ² [m²]
  double share;        ///< ε, in [0, 1)
  double mean_excess;  ///< τ > 0 [m]

  /// Mean and variance of the noise: ετ, and σ² + ετ²(2 − ε).
  Moments moments() const;
};

/// The Gaussian noise with which a Kalman update of innovation ν and prior H P Hᵀ has the mean and the variance of the
/// true posterior: `mean` is to be taken off the measurement, `variance` is R. With f the density of ν, g = −f′/f and
/// G = dg/dν, ν′ = g/G has the variance 1/G (C. J. Masreliez, "Approximate non-Gaussian filtering with linear state and
/// observation relations", IEEE Transactions on Automatic Control 20(1), 1975). Where f is flatter than any Gaussian
/// posterior the variance is the one at which the NIS is 4, with the mean still exact.
Moments equivalent_noise(const LateSignal& noise, double nu, double prior);

}  // namespace waymark::gnss
