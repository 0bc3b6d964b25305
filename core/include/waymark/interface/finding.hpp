// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "waymark/base/api.hpp"
#include "waymark/base/time.hpp"

namespace waymark {

/// A contradiction between the sensors of a robot, or between a sensor and physics, and what most likely causes it.
struct Finding {
  enum class Certainty {
    named,     ///< `sensors` has the one that is wrong
    one_of,    ///< one of `sensors` is wrong, the measurements do not decide which
    detected,  ///< something is wrong, and no sensor is named
  };
  Certainty certainty = Certainty::detected;
  std::string check;                 ///< "yaw rate", "speed", "heading", "unit", "delay", …
  std::vector<std::string> sensors;  ///< names of the YAML, most likely first
  std::string seen;                  ///< one clause, with figures and units
  std::string change;                ///< the line of the YAML that would fit; empty if there is none
  double sigmas = 0.0;               ///< how far it is from what is expected, in σ; 0: it is no matter of noise
  Time stamp{};                      ///< when it was first certain
};

/// Name of a certainty: "named", "one of", "detected".
constexpr const char* to_string(Finding::Certainty certainty) {
  constexpr const char* kWords[] = {"named", "one of", "detected"};
  return kWords[static_cast<int>(certainty)];
}

/// The finding in one line: suspects, what was seen, what to change.
WAYMARK_API std::string describe(const Finding& finding);

}  // namespace waymark
