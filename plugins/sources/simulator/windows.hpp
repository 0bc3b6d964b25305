// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "waymark/base/time.hpp"
#include "waymark/config/config.hpp"

namespace waymark::simulator {

/// Spans of time in which something is the case, such as outages.
class Windows {
 public:
  Windows() = default;  ///< none
  /// Reads a flat list: begin and end [s] of one window after the other; none if the key is absent. Throws ConfigError.
  Windows(const Config& config, const Config::Key& key);

  /// Whether `time` lies in a window; the end does not belong to it.
  bool contain(Duration time) const { return begin(time).has_value(); }
  /// When the window began in which `time` lies.
  std::optional<Duration> begin(Duration time) const;

 private:
  std::vector<std::pair<Duration, Duration>> spans_;
};

}  // namespace waymark::simulator
