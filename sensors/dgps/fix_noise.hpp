// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "waymark/config/config.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::dgps {

/// What the standard deviations of a fix are made of: the best that is known of this fix, never below the floor.
class FixNoise {
 public:
  /// Reads `sigma_m`, `sigma_vertical_m`, `use_reported_sigma`, `sigma_per_hdop_m`, `sigma_by_type_m`,
  /// `good_satellites`.
  explicit FixNoise(const Config& config);

  double horizontal(const GnssFix& fix) const;  ///< per axis [m]
  double vertical(const GnssFix& fix) const;    ///< [m]

 private:
  double sigma_;
  double sigma_vertical_;
  bool use_reported_;
  double sigma_per_hdop_;
  int good_satellites_;
  std::array<double, 6> sigma_by_type_{};
};

}  // namespace waymark::dgps
