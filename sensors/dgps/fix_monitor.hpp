// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string_view>

#include "waymark/base/error.hpp"
#include "waymark/base/time.hpp"
#include "waymark/config/config.hpp"
#include "waymark/io/archive.hpp"

namespace waymark::dgps {

/// One fix beside what the filter expected, in the plane.
struct ObservedFix {
  Time stamp{};
  Eigen::Vector2d z;           ///< the antenna, east and north [m]
  Eigen::Vector2d innovation;  ///< z − expectation [m]
  Eigen::Matrix2d S;           ///< its covariance: prediction, white noise and slow error of the fix [m²]
  double sigma = 0.0;          ///< of the fix per axis, white noise and slow error [m]
  double speed = 0.0;          ///< of the antenna as predicted [m/s]
  double speed_sigma = 0.0;
  bool standing = false;  ///< the host detects standstill
  bool follows = false;   ///< it and those before follow the last accepted one without a jump (FixContinuity)
};

/// Plausibility of fixes before they are fused (docs/math/dgps.md): a jump that no covariance
/// of the prediction explains, a position that does not change while the robot moves, one that wanders while it stands.
/// Its patience is bounded, so a filter that is wrong itself gets the fixes in the end; frozen ones excepted, which
/// carry nothing new.
class FixMonitor {
 public:
  enum class Verdict { good, jump, frozen, drifting };

  /// Reads `jump_sigmas`, `jump_patience`, `frozen_distance_m`, `drift_sigmas`, `drift_patience_s`.
  explicit FixMonitor(const Config& config);

  Verdict judge(const ObservedFix& fix);
  /// For UpdateList::report_degraded; empty for a good one.
  static std::string_view reason(Verdict verdict);

  template <class Archive>
  void serialize(Archive& archive) {
    if (archive.section("fix_monitor", 2) < 2) throw DataError("dgps: the checkpoint has an older version");
    archive(last_stamp_, last_, known_, moved_m_, believing_, place_, drifting_since_);
    for (int* count : {&repeats_, &agreeing_, &jumps_, &stood_}) archive.within(*count, 0, 1 << 30);
  }

 private:
  bool is_frozen(const ObservedFix& fix, double dt);
  bool is_drifting(const ObservedFix& fix);
  bool is_jump(const ObservedFix& fix, double dt);

  double jump_sigmas_;
  int jump_patience_;
  double frozen_distance_;
  double drift_sigmas_;
  Duration drift_patience_;

  std::optional<Time> last_stamp_;
  Eigen::Vector2d last_ = Eigen::Vector2d::Zero();   // the fix before this one, whatever became of it
  bool known_ = false;                               // a fix has been good already
  int repeats_ = 0;                                  // of one position
  double moved_m_ = 0.0;                             // by the robot meanwhile
  int agreeing_ = 0;                                 // jumps in a row that agree with each other
  int jumps_ = 0;                                    // jumps in a row
  bool believing_ = false;                           // the patience is over: the filter is wrong
  int stood_ = 0;                                    // fixes in the mean below
  Eigen::Vector2d place_ = Eigen::Vector2d::Zero();  // mean of the first fixes since the robot stands
  std::optional<Time> drifting_since_;
};

}  // namespace waymark::dgps
