// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "waymark/base/api.hpp"
#include "waymark/interface/rig.hpp"
#include "waymark/interface/snapshot.hpp"
#include "waymark/interface/source.hpp"

namespace waymark {

/// What a sink may know before the first snapshot.
struct RunInfo {
  std::filesystem::path out_dir;  ///< exists and is writable
  const Rig* rig = nullptr;
  std::shared_ptr<const Reference> reference;  ///< null if unknown
  std::string config = {};                     ///< the effective configuration as YAML; empty if unknown
};

/// Receives read-only snapshots. Constructed from the YAML: `explicit MySink(const Config&)`. Files are written through
/// `OutputFile`, so that a reader never sees half a file.
class WAYMARK_TYPE Sink {
 public:
  virtual ~Sink() = default;
  /// Once, before the first snapshot.
  virtual void start(const RunInfo&) = 0;
  /// Every measurement as the source delivers it, in order of arrival, before the filter has it: also those that come
  /// too late to be taken in. `sensor` is the index in the rig.
  virtual void arrived(const Measurement&) {}
  /// After every measurement that was taken in, in stamp order. The snapshot is valid only during the call.
  virtual void write(const Snapshot&) = 0;
  /// Once, after the last snapshot, also when the run was interrupted. `last` is null if there was none.
  virtual void finish(const Snapshot* last, const RunReport& report) = 0;
};

}  // namespace waymark
