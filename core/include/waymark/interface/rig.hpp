// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "waymark/base/api.hpp"
#include "waymark/math/pose.hpp"

namespace waymark {

/// Camera model of OpenCV: pinhole with the distortion of D. C. Brown (1966). All in pixels.
struct Intrinsics {
  int width = 0;
  int height = 0;
  double fx = 0.0;
  double fy = 0.0;
  double cx = 0.0;
  double cy = 0.0;
  std::array<double, 5> distortion{};  ///< k1, k2, p1, p2, k3
};

/// Name, payload and mounting of one sensor.
struct Mounting {
  std::string name;     ///< as in the YAML, unique
  std::string payload;  ///< payload type it must deliver ("waymark/LaserScan@1"), or empty: that of its plugin
  /// `base_T_sensor` of the YAML; absent if the YAML does not contain it. A camera's frame, too, has x forward, y left,
  /// z up (its optical frame follows from it: z forward, x right, y down).
  std::optional<Pose> T_base_sensor;
  std::optional<Intrinsics> intrinsics = {};  ///< of a camera
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
  /// Intrinsics of a camera. Throws ConfigError if there is no such sensor or its `intrinsics` are missing.
  const Intrinsics& intrinsics(std::string_view name) const;

 private:
  const Mounting& get(std::string_view name) const;

  std::vector<Mounting> mountings_;
};

}  // namespace waymark
