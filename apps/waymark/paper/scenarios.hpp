// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace waymark::paper {

/// One of the four scenarios of §4.4.
struct Scenario {
  int number;
  int particles;
  bool with_features;  ///< radius and signature, or the position alone
  std::string title;
  std::vector<std::string> overrides;  ///< of the YAML, which has one map
};

/// Scenarios 1 to 4: one particle with and without features, 25 particles with and without.
inline std::vector<Scenario> scenarios() {
  const auto scenario = [](int number, int particles, bool with_features) {
    std::string title = std::to_string(particles) + (particles == 1 ? " particle, " : " particles, ") +
                        (with_features ? "with radius and signature" : "position only");
    return Scenario{number,
                    particles,
                    with_features,
                    std::move(title),
                    {"filter.particles=" + std::to_string(particles),
                     std::string("maps.0.attributes=") + (with_features ? "[radius, signature]" : "[]")}};
  };
  return {scenario(1, 1, true), scenario(2, 1, false), scenario(3, 25, true), scenario(4, 25, false)};
}

}  // namespace waymark::paper
