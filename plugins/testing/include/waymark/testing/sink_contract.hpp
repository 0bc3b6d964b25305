// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <type_traits>

#include "waymark/config/config.hpp"
#include "waymark/interface/sink.hpp"
#include "waymark/testing/violations.hpp"

namespace waymark::testing {

/// Makes the sink under test from its mapping of the YAML; every call must give a new one.
using MakeSink = std::function<std::shared_ptr<Sink>(const Config&, const Rig&)>;

/// Under which circumstances a sink is checked.
struct SinkSetting {
  bool same_bytes = true;       ///< false: two runs may differ, which is then not looked at
  std::string run_config = {};  ///< `RunInfo::config`, the effective configuration of the run
};

/// Runs sinks, each in an output folder of its own, through a script of snapshots, the same in every run: not yet
/// started, every `Fate`, late ones, a pose that is lost, with and without datum, maps, radii and grids; a rig of
/// "wheels" (BodyTwist), "gps" (GnssFix), "lidar" (LaserScan) and "other", whose payload no plugin knows, but which
/// registers its fields. It checks
/// - the keys, as `check_keys` does; a constructor writes nothing;
/// - no call throws, in planar and in spatial motion, with `finish` for a last snapshot, for none and for an
/// interrupted
///   run, and without `finish`;
/// - only complete files are left (no `*.partial`), all of them below the output folder; none outside is open for
///   writing;
/// - two runs write the same files with the same bytes;
/// - an output folder that is missing, or vanishes during the run, is an Error or not noticed, but no other exception;
/// - `take_events` and `front` may be called by other threads (with the thread sanitizer: without a race), and events
///   are not empty.
/// Files are written to a folder of the system for temporary ones, and removed.
Violations check_sink(const MakeSink& make, const std::string& yaml, const SinkSetting& setting = {});

/// The same for class Plugin, whose constructor takes (const Config&) or (const Config&, const Rig&).
template <class Plugin>
Violations check_sink(const std::string& yaml, const SinkSetting& setting = {}) {
  const auto make = [](const Config& config, const Rig& rig) -> std::shared_ptr<Sink> {
    if constexpr (std::is_constructible_v<Plugin, const Config&, const Rig&>) {
      return std::make_shared<Plugin>(config, rig);
    } else {
      return std::make_shared<Plugin>(config);
    }
  };
  return check_sink(make, yaml, setting);
}

}  // namespace waymark::testing
