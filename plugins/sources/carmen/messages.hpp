// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "waymark/base/time.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::carmen {

/// Why a line cannot be used. Never leaves the plugin.
class Unusable : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The blank-separated words of one line; what is asked for and is not there, or is something else, throws Unusable.
class Fields {
 public:
  /// Splits the line; views point into it.
  void split(std::string_view line);

  bool empty() const { return words_.empty(); }
  std::size_t size() const { return words_.size(); }
  std::string_view name() const { return words_.front(); }                ///< the message's name
  std::string_view text(std::size_t index, std::string_view what) const;  ///< word `index`; the name is 0
  double number(std::size_t index, std::string_view what) const;          ///< finite
  std::size_t count(std::size_t index, std::string_view what) const;      ///< of values to come, at most a million
  Time time(std::size_t index, std::string_view what) const;
  /// Throws unless there are so many words.
  void expect(std::size_t size) const;

 private:
  std::vector<std::string_view> words_;
};

/// A pose in the plane of odometry: x, y [m], theta [rad].
struct PlanarPose {
  double x = 0.0;
  double y = 0.0;
  double theta = 0.0;
};

/// The two times at the end of a message.
struct Times {
  Time ipc;     ///< when the program that sent it made it
  Time logger;  ///< when the logger wrote it, since it was started
};

/// `ODOM x y theta tv rv accel ipc_timestamp ipc_hostname logger_timestamp`.
struct Odom {
  PlanarPose T_odom_base;
  double tv_mps = 0.0;
};

/// Which way the beams of a message that does not give it are spread.
struct BeamRule {
  double start_rad = 0.0;
  double step_rad = 0.0;
};

/// `FLASER`, `RLASER`, `ROBOTLASER1`, `ROBOTLASER2`: a scan, and where odometry had the robot.
struct LaserMessage {
  std::shared_ptr<LaserScan> scan;
  PlanarPose T_odom_base;
};

bool is_laser(std::string_view name);

// The messages of a line that holds one. Throw Unusable.
Odom read_odom(const Fields& fields);
/// Without a rule the older messages spread over 180 degrees: n beams 180/n apart, an odd number of beams with one at
/// either end. Only 180, 181, 360, 361, 720 and 721 beams are taken so.
LaserMessage read_laser(const Fields& fields, const std::optional<BeamRule>& rule);
/// `NMEAGGA nr utc latitude_dm N longitude_dm E quality satellites hdop …`: position and quality. The heights are left
/// unknown: programs filled those fields differently.
std::shared_ptr<GnssFix> read_fix(const Fields& fields);
/// The last three words of every message but PARAM: ipc_timestamp ipc_hostname logger_timestamp.
Times read_times(const Fields& fields);

}  // namespace waymark::carmen
