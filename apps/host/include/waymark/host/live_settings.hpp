// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "waymark/base/time.hpp"
#include "waymark/config/config.hpp"

namespace waymark::host {

/// Without any measurement of any sensor for so long, something is wrong with all of them: the pose is lost.
inline constexpr Duration kSilence = std::chrono::seconds(3);

/// How a running robot is served (`live:` of the YAML). Without a live source only `real_time` counts.
struct LiveSettings {
  bool real_time = false;             ///< logs are delivered as if their robots ran now
  double front_hz = 50.0;             ///< rate of the pose now
  std::size_t queue = 20000;          ///< most measurements that wait for the filter
  Duration overload_after{};          ///< age of the oldest waiting one at which scans are thinned
  std::vector<std::string> may_drop;  ///< sensors that lose their oldest measurements if the queue is full
  std::filesystem::path control;      ///< Unix socket of `waymark ctl`; empty: none
  std::string checkpoint;             ///< file in the output folder; empty: none
  Duration checkpoint_every{};
  bool resumes = false;  ///< a run begins at that checkpoint, if it is there and of this configuration
};

/// Reads `live:`. Throws ConfigError.
LiveSettings read_live_settings(const Config& yaml);

}  // namespace waymark::host
