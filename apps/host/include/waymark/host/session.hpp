// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "waymark/host/results.hpp"
#include "waymark/host/robot.hpp"

namespace waymark::host {

/// What a session needs beside its robot.
struct SessionOptions {
  std::filesystem::path out = {};                ///< folder of the sinks; exists and is writable
  std::optional<double> until_s = std::nullopt;  ///< the log ends this long after its first arrival [s]
  const std::atomic<bool>* stop = nullptr;       ///< true: `play` ends before the next measurement
  /// Called after every committed measurement, after the sinks, with the share of the log that was read (0 to 1,
  /// negative if unknown). The snapshot is valid during the call.
  std::function<void(const Snapshot&, double share)> observer = nullptr;
};

/// What a session ends with.
struct SessionResult {
  RunReport report;       ///< with the source's bad records and notices
  bool started = false;   ///< the filter had enough to start with
  std::string log_error;  ///< why the log could not be read to its end; empty if it could
  /// All that went wrong, one line each: `log_error`, plugins and sinks taken out of service, why nothing started.
  std::vector<std::string> failures;
};

/// One run of a robot: measurements in, results out. Either `play` takes them from the robot's source, or the program
/// adds them. Ends with `finish` or `suspend`, once.
class Session {
 public:
  /// Starts the robot's sinks. Throws ConfigError if the robot's parts do not fit.
  Session(Robot robot, SessionOptions options);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Goes on where `suspend` wrote `checkpoint`, for the same configuration and log; before `play`. Throws Error.
  void resume(const std::filesystem::path& checkpoint);
  /// Reads the source to its end, `until_s` or `stop`. A log that cannot be read on ends here, too: what was read until
  /// then is worth its results.
  void play();
  /// Takes one measurement, whose `sensor` is an index into the robot's sensors.
  void add(Measurement measurement);

  /// Commits what waits, and finishes the sinks.
  SessionResult finish();
  /// Writes a checkpoint, and finishes the sinks. What waits is not committed: a resumed session reads it again. Throws
  /// Error if the file cannot be written.
  SessionResult suspend(const std::filesystem::path& checkpoint);

  const Robot& robot() const { return robot_; }
  const Fusion& fusion() const { return *fusion_; }

 private:
  std::optional<Measurement> next();
  SessionResult conclude();

  Robot robot_;
  SessionOptions options_;
  Results results_;
  std::unique_ptr<Fusion> fusion_;
  std::optional<Time> first_arrival_;
  std::string log_error_;
};

}  // namespace waymark::host
