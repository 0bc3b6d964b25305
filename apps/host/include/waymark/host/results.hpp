// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "waymark/host/robot.hpp"

namespace waymark::host {

class RunFolder;

/// Passes a run to its sinks. A sink that throws is not called again; the others continue. The effective configuration
/// is written with the results, when they are complete: until then, that of an earlier run stays beside its results.
/// What else is left of that run is removed then.
class Results {
 public:
  /// Starts the sinks. `config_file`: text of `config.yaml`, for a run that owns its folder; empty: it does not. Throws
  /// Error if there is no room for it.
  Results(std::vector<SinkSlot> sinks, const RunInfo& info, const std::string& config_file = {});
  ~Results();
  Results(const Results&) = delete;
  Results& operator=(const Results&) = delete;

  void arrived(const Measurement& measurement);
  void dropped(const Measurement& measurement);
  void commanded(Time arrival, std::string_view command);
  /// May be called by another thread than the rest.
  void front(const Belief& belief);
  /// What happened to the sinks since the last call.
  std::vector<std::string> take_events();
  void write(const Snapshot& snapshot);
  void finish(const Snapshot* last, const RunReport& report);

  /// One line for every sink that failed: "sink tum: taken out of service: …".
  std::vector<std::string> failures() const;
  /// After `finish`: what happened to the results of an earlier run in the folder, one line each.
  const std::vector<std::string>& replaced() const { return replaced_; }

 private:
  void replace_older(bool complete);
  void for_each(const std::function<void(Sink&)>& call);

  RunInfo info_;
  std::unique_ptr<RunFolder> folder_;  // null: sessions share it
  std::vector<std::string> replaced_;
  std::filesystem::path new_config_;  // until it takes the older one's place; empty: there is none
  mutable std::mutex mutex_;          // of what follows
  std::vector<SinkSlot> sinks_;
  std::vector<std::string> failures_;
};

}  // namespace waymark::host
