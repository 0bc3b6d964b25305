// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "waymark/base/api.hpp"
#include "waymark/interface/rig.hpp"
#include "waymark/interface/snapshot.hpp"
#include "waymark/interface/source.hpp"

namespace waymark {

/// Information about a run, before its first snapshot.
struct RunInfo {
  std::filesystem::path out_dir;  ///< exists and is writable
  const Rig* rig = nullptr;
  std::shared_ptr<const Reference> reference;  ///< null if unknown
  std::string config = {};                     ///< the effective configuration as YAML; empty if unknown
  std::string name = {};                       ///< for titles: that of the YAML without its ending; empty if unknown
};

/// Receives read-only snapshots. Constructed from the YAML: `explicit MySink(const Config&)`. Files are written through
/// `OutputFile`, so that a reader never sees an incomplete file.
class WAYMARK_TYPE Sink {
 public:
  virtual ~Sink() = default;
  /// Called once, before the first snapshot.
  virtual void start(const RunInfo&) = 0;
  /// Called for every measurement in order of arrival, before the filter processes it; also for those that are too
  /// late. `sensor` is the index in the rig.
  virtual void arrived(const Measurement&) {}
  /// Called for every measurement of a live robot that is not passed to the filter, which could not keep up.
  virtual void dropped(const Measurement&) {}
  /// Called for every command that changes the running filter (`waymark ctl`), between the measurements, in order.
  virtual void commanded(Time /*arrival*/, std::string_view /*command*/) {}
  /// Live robots only: the belief at the time of the call, at `live.front_hz`. Called by the thread of outputs, during
  /// the other calls: a sink that implements it protects what both use.
  virtual void front(const Belief&) {}
  /// What happened to the sink since the last call, one line each: a full disk, a lost connection. May be called at any
  /// time by any thread.
  virtual std::vector<std::string> take_events() { return {}; }
  /// Called after every measurement that the filter has processed or rejected (`Snapshot::fate`). The snapshot is valid
  /// only during the call.
  virtual void write(const Snapshot&) = 0;
  /// Called once, after the last snapshot, also if the run was interrupted. `last` is null if there was none.
  virtual void finish(const Snapshot* last, const RunReport& report) = 0;
};

}  // namespace waymark
