// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "waymark/base/time.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::dgps {

/// A fix and how far the robot drives, for its continuity.
struct FixStep {
  Time stamp{};
  Eigen::Vector2d z;         ///< the antenna, east and north [m]
  double white_sigma = 0.0;  ///< per axis [m]
  double slow_sigma = 0.0;   ///< of the slowly varying error per axis [m]
  double slow_tau_s = 1.0;
  double speed = 0.0;  ///< of the antenna as predicted [m/s]
  double speed_sigma = 0.0;
};

/// Whether the fixes follow one another as far as the robot drives (docs/math/dgps.md, "Continuity"). A receiver that
/// jumps breaks the run at the jump. A robot that slips does not: its fixes go on from the last accepted one, as far as
/// the wheels say, in another direction. So a rejected fix that follows shows that the prediction is wrong.
class FixContinuity {
 public:
  /// Takes the next fix, whatever becomes of it.
  void take(const FixStep& fix);
  /// The host accepted the last one: a run begins with it.
  void accept();
  /// True if no fix jumped since the last accepted one.
  bool is_unbroken() const { return last_ && !broken_; }
  /// True if the run is too unlikely for outliers: a rejected fix is right.
  bool is_certain() const;

  template <class Archive>
  void serialize(Archive& archive) {
    archive.section("fix_continuity", 1);
    archive(last_, z_, white_variance_, slow_variance_, speed_, broken_);
    archive.within(evidence_, kAfterGap, kMostEvidence);
  }

 private:
  static constexpr double kMostEvidence = 1e12;
  static constexpr double kAfterGap = 0.01;

  std::optional<Time> last_;
  Eigen::Vector2d z_ = Eigen::Vector2d::Zero();  // of the last fix
  double white_variance_ = 0.0;
  double slow_variance_ = 0.0;
  double speed_ = 0.0;
  bool broken_ = false;
  double evidence_ = 1.0;  // likelihood of the run by that of outliers
};

}  // namespace waymark::dgps
