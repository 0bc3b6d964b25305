// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/paper/scenarios.hpp"

#include <fmt/format.h>

namespace waymark::paper {
namespace {

Scenario scenario(int number, int particles, const std::string& what, std::vector<std::string> overrides) {
  overrides.push_back(fmt::format("filter.particles={}", particles));
  return {.number = number,
          .title = fmt::format("{} particle{}, {}", particles, particles == 1 ? "" : "s", what),
          .overrides = std::move(overrides),
          .picture = fmt::format("scenario_{}.png", number)};
}

/// Scenarios 1 to 4.
std::vector<Scenario> four_scenarios() {
  std::vector<Scenario> scenarios;
  for (const int particles : {1, 25}) {
    const int number = particles == 1 ? 1 : 3;
    scenarios.push_back(
        scenario(number, particles, "with radius and signature", {"maps.0.attributes=[radius, signature]"}));
    scenarios.push_back(scenario(number + 1, particles, "position only", {"maps.0.attributes=[]"}));
  }
  return scenarios;
}

}  // namespace

Experiment scenarios_of_the_paper(const std::string& published) {
  Experiment experiment{
      "paper", "The paper's experiment",
      "§4.4 of the paper: cylinders, three loop closures, the robot drives from left to right and back.",
      four_scenarios()};
  if (published.empty()) return experiment;
  for (Scenario& one : experiment.scenarios) one.filter = "Waymark";
  for (Scenario& one : four_scenarios()) {
    one.config = published;
    one.filter = "As published";
    one.picture = "published_" + one.picture;
    experiment.scenarios.push_back(std::move(one));
  }
  return experiment;
}

Experiment signature_rules() {
  Experiment experiment{
      "signature",
      "What a signature is worth",
      "The course of the [paper's experiment](paper.md), with radius, and with signatures that are fused "
      "by (4.10) or counted (Dirichlet), compared by (4.7) (Bhattacharyya); or without signatures.",
      {}};
  int number = 0;
  for (const int particles : {1, 25}) {
    for (const char* rule : {"product", "dirichlet"}) {
      experiment.scenarios.push_back(scenario(
          ++number, particles, rule,
          {"maps.0.attributes=[radius, signature]", fmt::format("maps.0.association.signature_fusion={}", rule)}));
    }
    experiment.scenarios.push_back(scenario(++number, particles, "no signature", {"maps.0.attributes=[radius]"}));
  }
  return experiment;
}

}  // namespace waymark::paper
