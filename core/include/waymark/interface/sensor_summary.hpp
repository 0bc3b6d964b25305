// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "waymark/base/api.hpp"
#include "waymark/interface/snapshot.hpp"

namespace waymark {

/// What a table says of one sensor over a run.
struct SensorSummary {
  std::string name;
  std::string plugin;  ///< empty: for maps only
  double rate_hz = 0.0;
  std::uint64_t measurements = 0;
  std::uint64_t used = 0;      ///< by the filter or a map
  std::uint64_t rejected = 0;  ///< by the gate, or unusable
  /// Mean of the NIS over its expectation, which is 1 for a consistent filter; NaN without updates.
  double nis_ratio = 0.0;
  /// Where that mean lies in 95 % of the runs of a consistent filter (χ² with the rows of all updates as degrees of
  /// freedom; Bar-Shalom, Li, Kirubarajan, 2001, §5.4); NaN without updates.
  double nis_low = 0.0;
  double nis_high = 0.0;
  /// What the NIS means, in a few words: "consistent"; "overconfident, innovations 2.1 times σ"; "held out".
  std::string verdict;
};

/// The summary of one sensor's report. Innovations are rarely independent, so the band is too narrow for long runs: the
/// verdict is "consistent" within the band, and also from half to twice the expectation. Small innovations of a motion
/// source are no verdict: the prediction of a motion is wide by construction. Of a sensor for maps alone the
/// innovations are those of the pose that the maps determine, so they judge the motion source.
WAYMARK_API SensorSummary summarize(const SensorReport& sensor);

}  // namespace waymark
