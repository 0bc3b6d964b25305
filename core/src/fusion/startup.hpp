// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "fusion/sensor_record.hpp"
#include "fusion/start_finder.hpp"

namespace waymark::fusion {

/// Keeps what arrives until the start pose is found and the motion is measured.
class Startup {
 public:
  /// `motion_from_maps`: no sensor measures the motion, so the first scan begins it.
  Startup(const StartSettings& settings, const StateLayout& layout, StartKnowledge knowledge, bool motion_from_maps)
      : finder_(settings, layout, knowledge), motion_from_maps_(motion_from_maps) {}

  /// Looks at the next measurement; `hint` is what its sensor reports of the start. Returns how the filter begins once
  /// that is known.
  std::optional<Start> consider(const Measurement& m, const std::optional<StartHint>& hint,
                                const std::vector<SensorRecord>& sensors);
  /// False once the start pose is found.
  bool looks_for_pose() const { return !start_; }
  /// What has arrived so far, in the total order; it is forgotten here.
  std::vector<Measurement> release() { return std::exchange(buffer_, {}); }
  /// What is still missing, for the user.
  std::string missing() const;

 private:
  StartFinder finder_;
  bool motion_from_maps_;
  std::vector<Measurement> buffer_;
  std::optional<Start> start_;  // found, but no motion is measured yet
};

}  // namespace waymark::fusion
