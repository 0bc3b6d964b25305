// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace waymark {

/// Health of one sensor. The states are in order of severity.
struct SensorHealth {
  enum class State {
    ok,
    degraded,  ///< fused, but partly gated or unusable, or the sensor itself reports degraded measurements
    faulty,    ///< most measurements are gated or unusable, or the plugin is out of service
    silent     ///< no measurements any more, or none yet
  };
  State state = State::ok;
  std::string reason;  ///< empty while ok: "position frozen while moving", "7 of the last 20 updates gated"
};

/// Health of the estimated pose.
struct Health {
  enum class State {
    ok,
    degraded,  ///< the covariance is consistent as far as the filter can detect, but an input is missing or faulty
    lost       ///< the pose must not be used for control
  };
  State state = State::ok;
  std::string reason;  ///< of the state; empty while ok: "gps is faulty: 14 of the last 20 updates gated"
  std::vector<SensorHealth> sensors;  ///< in the order of the YAML
  /// Estimated probability that the position is off by more than 3σ of its covariance. 0.011 for a consistent planar
  /// filter (χ² with two degrees of freedom); more if the innovations of absolute sensors are larger than S predicts.
  double probability_off_3_sigma = 0.0;
};

/// How long the pose was in which state, in time of the log; pauses of the whole log are left out [s].
struct HealthTimes {
  double ok_s = 0.0;
  double degraded_s = 0.0;
  double lost_s = 0.0;

  /// Share of the time in which the pose was lost; 0 if there was none.
  double lost_share() const {
    const double all = ok_s + degraded_s + lost_s;
    return all > 0.0 ? lost_s / all : 0.0;
  }
};

/// Name of a state: "ok", "degraded", …
constexpr const char* to_string(SensorHealth::State state) {
  constexpr const char* kWords[] = {"ok", "degraded", "faulty", "silent"};
  return kWords[static_cast<int>(state)];
}
constexpr const char* to_string(Health::State state) {
  constexpr const char* kWords[] = {"ok", "degraded", "lost"};
  return kWords[static_cast<int>(state)];
}

}  // namespace waymark
