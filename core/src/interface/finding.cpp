// SPDX-License-Identifier: Apache-2.0
#include "waymark/interface/finding.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace waymark {

std::string describe(const Finding& finding) {
  std::string who;
  if (finding.certainty == Finding::Certainty::named && !finding.sensors.empty()) {
    who = finding.sensors.front() + ": ";
  } else if (!finding.sensors.empty()) {
    who = fmt::format("one of {}: ", fmt::join(finding.sensors, ", "));
  }
  std::string text = fmt::format("{}{}", who, finding.seen);
  if (finding.sigmas > 0.0) text += fmt::format(" ({:.0f} sigma)", finding.sigmas);
  if (!finding.change.empty()) text += "; " + finding.change;
  return text;
}

}  // namespace waymark
