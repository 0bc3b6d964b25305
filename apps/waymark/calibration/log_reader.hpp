// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "waymark/config/config.hpp"
#include "waymark/host/robot.hpp"

namespace waymark::calibration {

/// A robot's log, or its first part, without a filter.
class LogReader {
 public:
  /// `until_s`: after the first arrival. Throws Error if the source is none or that of a running robot, and what
  /// `Robot::load` throws.
  LogReader(const std::filesystem::path& yaml, const std::vector<Config::Override>& overrides,
            std::optional<double> until_s);

  /// The next measurement of one of the robot's sensors, with its number in the log as `sequence`; nothing at the end.
  /// Throws what the source throws.
  std::optional<Measurement> next();
  const host::Robot& robot() const { return robot_; }
  /// First arrival of the log; nothing before the first call of `next`.
  std::optional<Time> first() const { return first_; }

 private:
  host::Robot robot_;
  std::optional<double> until_s_;
  std::optional<Time> first_;
  std::uint64_t number_ = 0;
};

}  // namespace waymark::calibration
