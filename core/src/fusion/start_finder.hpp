// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "waymark/host/fusion_settings.hpp"

namespace waymark::fusion {

/// How the filter begins.
struct Start {
  Belief prior;
  bool draw = false;              ///< the particles draw their start from the prior; else it is the map's gauge
  std::uint32_t used_sensor = 0;  ///< the measurement that gave the position; not to be fused a second time
  std::uint64_t used_sequence = 0;
  bool used = false;
};

/// What tells where the robot is.
struct StartKnowledge {
  bool absolute_known;  ///< a sensor could tell the position, fused or only used for the start
  bool absolute_fused;  ///< it also goes on to be fused
  bool place_known;     ///< a map of the place is there
};

/// Gathers what is needed to begin: pose from the YAML, from a fix, heading from a compass or from two fixes more than
/// 5σ apart.
class StartFinder {
 public:
  StartFinder(const StartSettings& settings, const StateLayout& layout, StartKnowledge knowledge)
      : settings_(settings), layout_(layout), knowledge_(knowledge) {}

  /// Looks at the next measurement in stamp order; `hint` is what its sensor says.
  std::optional<Start> consider(const Measurement& measurement, const std::optional<StartHint>& hint);

  /// What is still missing, for the user.
  std::string missing() const;

 private:
  struct Fix {
    std::uint32_t sensor;
    Time stamp;
    std::uint64_t sequence;
    StartHint hint;
  };

  Start make_start(Time stamp, const Fix* fix) const;

  StartSettings settings_;
  const StateLayout& layout_;
  StartKnowledge knowledge_;
  const Fix* first_fix() const { return first_fixes_.empty() ? nullptr : &first_fixes_.front(); }
  void take_course(const Measurement& measurement, const StartHint& hint);

  std::vector<Fix> first_fixes_;  // one of each sensor, in the order of their coming
  std::optional<double> yaw_;
  double yaw_sigma_ = 0.0;
};

}  // namespace waymark::fusion
