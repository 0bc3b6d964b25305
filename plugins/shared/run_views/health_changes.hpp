// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "waymark/interface/health.hpp"
#include "waymark/interface/snapshot.hpp"

namespace waymark::run_views {

/// When the health of the pose and of each sensor changed; at most so many changes, the first ones.
class HealthChanges {
 public:
  static constexpr std::size_t kPose = static_cast<std::size_t>(-1);
  struct Change {
    Time stamp{};
    std::size_t sensor = kPose;  ///< index in the rig, or kPose
    const char* state = "ok";
    std::string reason;
  };
  /// What all is in before the first call of `add`.
  enum class Before {
    unknown,  ///< the first state counts as a change, too
    ok
  };

  HealthChanges(std::size_t most, Before before) : most_(most) {
    if (before == Before::ok) {
      pose_ = Health::State::ok;
      sensor_before_ = SensorHealth::State::ok;
    }
  }

  void add(Time stamp, const Health& health) {
    if (health.state != pose_) note({stamp, kPose, to_string(health.state), health.reason});
    pose_ = health.state;
    sensors_.resize(health.sensors.size(), sensor_before_);
    for (std::size_t i = 0; i < sensors_.size(); ++i) {
      const SensorHealth& sensor = health.sensors[i];
      if (sensor.state != sensors_[i]) note({stamp, i, to_string(sensor.state), sensor.reason});
      sensors_[i] = sensor.state;
    }
  }

  const std::vector<Change>& changes() const { return changes_; }
  std::size_t left_out() const { return left_out_; }

 private:
  void note(Change change) {
    if (changes_.size() < most_) {
      changes_.push_back(std::move(change));
    } else {
      ++left_out_;
    }
  }

  std::size_t most_;
  std::optional<Health::State> pose_;
  std::optional<SensorHealth::State> sensor_before_;
  std::vector<std::optional<SensorHealth::State>> sensors_;
  std::vector<Change> changes_;
  std::size_t left_out_ = 0;
};

}  // namespace waymark::run_views
