// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "waymark/interface/health.hpp"
#include "waymark/interface/snapshot.hpp"

namespace waymark::report {

/// When the health of the pose and of each sensor changed; the first 2000 changes.
class HealthChanges {
 public:
  static constexpr std::size_t kMost = 2000;
  static constexpr std::size_t kPose = static_cast<std::size_t>(-1);
  struct Change {
    Time stamp{};
    std::size_t sensor = kPose;  ///< index in the rig, or kPose
    const char* state = "ok";
    std::string reason;
  };

  void add(Time stamp, const Health& health) {
    if (changes_.empty()) note({stamp, kPose, to_string(health.state), health.reason});
    if (health.state != pose_) note({stamp, kPose, to_string(health.state), health.reason});
    pose_ = health.state;
    for (std::size_t i = 0; i < health.sensors.size(); ++i) {
      const SensorHealth& sensor = health.sensors[i];
      const bool is_new = i >= sensors_.size();
      if (is_new) sensors_.push_back(sensor.state);
      if (is_new || sensor.state != sensors_[i]) note({stamp, i, to_string(sensor.state), sensor.reason});
      sensors_[i] = sensor.state;
    }
  }

  const std::vector<Change>& changes() const { return changes_; }
  std::size_t left_out() const { return left_out_; }

 private:
  void note(Change change) {
    if (changes_.size() < kMost) {
      changes_.push_back(std::move(change));
    } else {
      ++left_out_;
    }
  }

  Health::State pose_ = Health::State::ok;
  std::vector<SensorHealth::State> sensors_;
  std::vector<Change> changes_;
  std::size_t left_out_ = 0;
};

}  // namespace waymark::report
