// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "waymark/host/diagnosis.hpp"
#include "waymark/host/folder_lock.hpp"
#include "waymark/host/results.hpp"
#include "waymark/host/robot.hpp"

namespace waymark::host {

struct Gap;
class LiveRun;
class LogIdentity;

/// Options of a session.
struct SessionOptions {
  std::filesystem::path out = {};  ///< folder of the sinks; exists and is writable
  std::string name = {};           ///< of the run, for titles; empty: that of the YAML without its ending
  /// The folder is locked, and the effective configuration is written beside the results. False: sessions share it.
  bool owns_folder = true;
  std::optional<double> until_s = std::nullopt;  ///< `play` ends this long after the first arrival [s]
  const std::atomic<bool>* stop = nullptr;       ///< true: `play` ends before the next measurement
  /// Called after every committed measurement, after the sinks, with the share of the log that was read (0 to 1,
  /// negative if unknown). The snapshot is valid during the call.
  std::function<void(const Snapshot&, double share)> observer = nullptr;
  /// Of a running robot: called with each event of filter, diagnosis, sources, queue and sinks when it happens.
  std::function<void(const Event&)> on_event = nullptr;
};

/// Result of a session.
struct SessionResult {
  RunReport report;       ///< with the source's bad records and notices
  bool started = false;   ///< the filter has started
  std::string log_error;  ///< error that ended the log early; empty if there was none
  /// All failures, one line each: `log_error`, plugins and sinks taken out of service, why the filter did not start, a
  /// reference that cannot be read.
  std::vector<std::string> failures;
  /// That the pose was lost for a larger share of the run than `health.max_lost_share` allows; empty if it was not.
  std::string lost;
  std::vector<std::string> replaced;  ///< what happened to the results of an earlier run, one line each
};

/// One run of a robot. `play` reads the measurements from the robot's source, or the program adds them. Ends with one
/// call of `finish` or `suspend`.
class Session {
 public:
  /// Starts the robot's sinks. Throws ConfigError if the robot's parts do not fit, Error if another run writes to the
  /// output folder.
  Session(Robot robot, SessionOptions options);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Continues from the checkpoint that `suspend` wrote. Call it before `play`. Throws Error if it is damaged, or if
  /// configuration (but for sinks, plugin_path and filter.threads) or log are others.
  void resume(const std::filesystem::path& checkpoint);
  /// The same for a running robot that starts again: if the file cannot be used (missing, damaged, of another
  /// configuration or version), the session begins without it. Returns the reason then, else an empty text.
  std::string resume_if_possible(const std::filesystem::path& checkpoint);
  /// Reads the source to its end, `until_s` or `stop`. An error in the log or a lack of memory also ends it
  /// (`SessionResult::log_error`); results up to there are kept.
  void play();
  /// Adds one measurement; `Measurement::sensor` is an index into the robot's sensors.
  void add(Measurement measurement);

  /// Commits the buffered measurements and finishes the sinks.
  SessionResult finish();
  /// Writes a checkpoint and finishes the sinks. Buffered measurements are not committed: a resumed session reads them
  /// again. If the file cannot be written, the results are, and `failures` has the reason.
  SessionResult suspend(const std::filesystem::path& checkpoint);

  const Robot& robot() const { return robot_; }
  const Fusion& fusion() const { return *fusion_; }
  /// What contradicts what among the sensors, as far as it is certain; empty if `diagnosis.enabled` is false.
  std::vector<Finding> findings() const;

 private:
  std::optional<Measurement> next();
  std::unique_ptr<Fusion> make_fusion(const Robot& robot);
  std::string read(const std::filesystem::path& checkpoint, std::uint64_t& log_identity) const;
  void load(const std::filesystem::path& checkpoint, std::string state, std::uint64_t log_identity);
  void write(const std::filesystem::path& checkpoint) const;
  void obey(const Measurement& command);
  void follow_live();
  void note_missing(std::uint32_t sensor, const Gap& gap, Time arrival);
  void take_new_events();
  void keep(Event event);
  void diagnose(const Measurement& measurement);
  void note_findings();
  void add_findings(SessionResult& result) const;
  void write_live_checkpoint_if_due();
  void retune(const std::string& key_and_value);
  std::string save_maps();
  std::string write_live_checkpoint();
  SessionResult conclude();

  Robot robot_;
  SessionOptions options_;
  std::unique_ptr<FolderLock> lock_;  // before the sinks open their files
  std::string reference_error_;
  Results results_;
  std::unique_ptr<Fusion> fusion_;
  std::optional<Time> first_arrival_;
  Time last_arrival_{};
  std::unique_ptr<Diagnosis> diagnosis_;  // null: it is switched off
  std::unique_ptr<LogIdentity> log_;
  std::uint64_t config_identity_;       // of the configuration as it was loaded
  std::vector<std::string> retunings_;  // since, in their order
  std::unique_ptr<LiveRun> live_;       // of a running robot
  std::vector<Event> live_events_;      // or of its record: the first ones and the last ones
  std::uint64_t live_events_left_out_ = 0;
  bool stopped_ = false;  // by a command
  std::string log_error_;
  std::string checkpoint_error_;
  std::string checkpoint_problem_;  // of the last checkpoint of a running robot; empty: none
};

}  // namespace waymark::host
