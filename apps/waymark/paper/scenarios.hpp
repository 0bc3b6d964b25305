// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace waymark::paper {

/// One way to run the filter on a course.
struct Scenario {
  int number;
  std::string title;
  std::vector<std::string> overrides;  ///< of the YAML, which has one map
  std::string config = {};             ///< YAML of this filter, with the same source; empty: that of the experiment
  std::string filter = {};             ///< what the scenarios with that YAML have in common, as a heading; may be empty
  std::string picture = {};            ///< file of its picture, without folder
};

/// Scenarios that are run on the same measurements, to be compared.
struct Experiment {
  std::string name;  ///< of its files
  std::string heading;
  std::string text;
  std::vector<Scenario> scenarios;
};

/// Scenarios 1 to 4 of §4.4: one particle with and without radius and signature, 25 particles with and without. Where
/// `published` is not empty, the YAML of the algorithm as published, they are run with both.
Experiment scenarios_of_the_paper(const std::string& published);

/// Rules for signatures: product (4.10), Dirichlet, and none, with one particle and with 25.
Experiment signature_rules();

}  // namespace waymark::paper
