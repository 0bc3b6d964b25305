// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace waymark {

/// How one sensor does, as seen from the filter. The order is that of rising concern.
struct SensorHealth {
  enum class State {
    ok,
    degraded,  ///< it is fused, with less trust than it asks for: the gate takes some of it, or it doubts itself
    faulty,    ///< most of what it says cannot be used, or it is out of service
    silent     ///< it has stopped, or has never delivered
  };
  State state = State::ok;
  std::string reason;  ///< empty while ok: "position frozen while moving", "7 of the last 20 updates gated"
};

/// How far the pose can be trusted, and why not.
struct Health {
  enum class State {
    ok,
    degraded,  ///< the pose is what the covariance says as far as the filter can see, but something is missing
    lost       ///< do not steer by this pose
  };
  State state = State::ok;
  std::string reason;                 ///< empty while ok: "gps is faulty: 14 of the last 20 updates gated"
  std::vector<SensorHealth> sensors;  ///< in the order of the YAML
  /// Estimated probability that the position is off by more than 3σ of its covariance: 0.011 for an honest planar
  /// filter (χ² with two degrees of freedom), more where absolute sensors contradict the prediction more than S says.
  double probability_off_3_sigma = 0.0;
};

/// "ok", "degraded", …
constexpr const char* to_string(SensorHealth::State state) {
  constexpr const char* kWords[] = {"ok", "degraded", "faulty", "silent"};
  return kWords[static_cast<int>(state)];
}
constexpr const char* to_string(Health::State state) {
  constexpr const char* kWords[] = {"ok", "degraded", "lost"};
  return kWords[static_cast<int>(state)];
}

}  // namespace waymark
