// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace waymark::calibration {

/// The Allan deviation for one averaging time (D. W. Allan, Proc. IEEE 54, 1966).
struct AllanPoint {
  double tau_s;      ///< averaging time
  double deviation;  ///< in the unit of the samples
  double share;      ///< σ of the deviation as a share of it, of independent averages
};

/// Overlapping Allan deviation of evenly spaced samples, three averaging times a decade, up to a ninth of the samples.
std::vector<AllanPoint> allan_deviation(const std::vector<double>& samples, double period_s);

/// The density of white noise, in the samples' unit times √s, where the deviation falls as 1/√τ: the mean of
/// deviation · √τ for 0.1 s <= τ <= 2 s, and its σ. Zero for too few samples.
struct WhiteNoise {
  double density = 0.0;
  double sigma = 0.0;
};
WhiteNoise white_noise(const std::vector<AllanPoint>& points);

/// The point with the lowest deviation; the last ones count as far as they are known to a third.
AllanPoint lowest(const std::vector<AllanPoint>& points);

}  // namespace waymark::calibration
