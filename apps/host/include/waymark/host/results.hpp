// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "waymark/host/robot.hpp"

namespace waymark::host {

/// The results of a run as its sinks write them. A sink that throws is left out from then on, the others go on.
class Results {
 public:
  /// Starts the sinks.
  Results(std::vector<SinkSlot> sinks, const RunInfo& info);

  void arrived(const Measurement& measurement);
  void write(const Snapshot& snapshot);
  void finish(const Snapshot* last, const RunReport& report);

  /// One line for every sink that was left out: "sink tum: taken out of service: …".
  const std::vector<std::string>& failures() const { return failures_; }

 private:
  void for_each(const std::function<void(Sink&)>& call);

  std::vector<SinkSlot> sinks_;
  std::vector<std::string> failures_;
};

}  // namespace waymark::host
