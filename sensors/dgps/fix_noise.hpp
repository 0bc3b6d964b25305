// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "waymark/config/config.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::dgps {

/// What the standard deviations of a fix are made of: the best that is known of this fix, never below the floor. An
/// error has a white part and a slowly varying one; where the YAML does not give the slow part, it follows the white
/// one (docs/math/dgps.md, "Classes of receivers").
class FixNoise {
 public:
  /// Reads `receiver`, `sigma_m`, `sigma_vertical_m`, `use_reported_sigma`, `sigma_per_hdop_m`, `sigma_by_type_m`,
  /// `good_satellites`, `offset_sigma_m`.
  explicit FixNoise(const Config& config);

  double horizontal(const GnssFix& fix) const;  ///< white part, per axis [m]
  double vertical(const GnssFix& fix) const;    ///< [m]
  double slow(const GnssFix& fix) const;        ///< slowly varying part, per horizontal axis [m]
  /// σ of the slowly varying error as a state, that of a usual fix of this receiver [m]; 0: there is none.
  double usual_slow() const { return usual_slow_; }

 private:
  double sigma_of_class(const GnssFix& fix) const;
  double from_properties(const GnssFix& fix) const;

  GnssFix::Type receiver_ = GnssFix::Type::single;
  bool has_sigma_ = false;       // given, not of the class
  bool has_slow_sigma_ = false;  // the same of the slow part
  double sigma_ = 0.0;           // the floor
  double usual_slow_ = 0.0;
  double sigma_vertical_;
  bool use_reported_;
  double sigma_per_hdop_;
  int good_satellites_;
  std::array<double, 6> sigma_by_type_{};
};

}  // namespace waymark::dgps
