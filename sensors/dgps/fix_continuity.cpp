// SPDX-License-Identifier: Apache-2.0
#include "fix_continuity.hpp"

#include <algorithm>
#include <cmath>

namespace waymark::dgps {

namespace {

constexpr double kOutlierRadius = 20.0;  // [m]: outliers lie anywhere within it
constexpr double kEnough = 30.0;         // times as likely as outliers
constexpr double kSigmas = 3.0;
constexpr double kStretch = 1.1;   // scale error of wheels, and acceleration between two fixes
constexpr double kShortest = 0.5;  // chord by way: a curve between two fixes, or wheels that spin

}  // namespace

void FixContinuity::take(const FixStep& fix) {
  const double white = fix.white_sigma * fix.white_sigma;
  const double slow = fix.slow_sigma * fix.slow_sigma;
  if (last_) {
    const double dt = std::max(0.0, to_seconds(fix.stamp - *last_));
    const double change = 1.0 - std::exp(-dt / fix.slow_tau_s);
    const double sigma = std::sqrt(white + white_variance_ + (slow + slow_variance_) * change);
    const double margin = kSigmas * sigma;
    const double longest = kStretch * (std::max(speed_, fix.speed) + 2.0 * fix.speed_sigma) * dt + margin;
    const double shortest = kShortest * (std::min(speed_, fix.speed) - 2.0 * fix.speed_sigma) * dt - margin;
    const double moved = (fix.z - z_).norm();
    if (moved > longest || moved < shortest) {
      broken_ = true;
      evidence_ = 1.0;
    } else if (longest > kOutlierRadius) {
      // After a gap the robot can be anywhere, and receivers need some fixes to settle.
      evidence_ = kAfterGap;
    } else if (!broken_) {
      const double ratio = kOutlierRadius / std::max(longest, 1e-3);
      evidence_ = std::min(evidence_ * ratio * ratio, kMostEvidence);
    }
  }
  last_ = fix.stamp;
  z_ = fix.z;
  white_variance_ = white;
  slow_variance_ = slow;
  speed_ = fix.speed;
}

void FixContinuity::accept() {
  broken_ = false;
  evidence_ = 1.0;
}

bool FixContinuity::is_certain() const { return is_unbroken() && evidence_ >= kEnough; }

}  // namespace waymark::dgps
