// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "waymark/api.hpp"
#include "waymark/pose.hpp"

namespace waymark {

/// One sensor as it is mounted on the robot.
struct Mounting {
  std::string name;     ///< as in the YAML, unique
  std::string payload;  ///< payload type it must deliver ("waymark/LaserScan@1"), or empty: what its plugin takes
  std::optional<Pose> T_base_sensor;  ///< `base_T_sensor` of the YAML; absent if the YAML does not give it
};

/// The robot's sensors in the order of the YAML, which is also the order of measurements with equal stamps.
class WAYMARK_API Rig {
 public:
  explicit Rig(std::vector<Mounting> mountings) : mountings_(std::move(mountings)) {}

  const std::vector<Mounting>& mountings() const { return mountings_; }
  /// Index of the sensor, or -1.
  int find(std::string_view name) const;
  /// Extrinsics of a sensor. Throws ConfigError if there is no such sensor or its `base_T_sensor` is missing.
  const Pose& T_base_sensor(std::string_view name) const;

 private:
  std::vector<Mounting> mountings_;
};

}  // namespace waymark
