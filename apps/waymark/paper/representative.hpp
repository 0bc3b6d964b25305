// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "apps/waymark/paper/page.hpp"

namespace waymark::paper {

/// A seed on which a scenario fails as it does on most, to be drawn beside a figure of the paper.
struct Representative {
  std::string figure;     ///< of the paper: "4.5"
  std::string picture;    ///< file, without folder
  std::string failure;    ///< what has gone wrong on this seed
  std::string criterion;  ///< how it was chosen, and among how many
  std::size_t scenario;   ///< index into the scenarios of the experiment
  std::size_t seed;       ///< index into the seeds
};

/// The failing seeds that stand for Fig. 4.5 (scenario 2: cylinders drawn twice) and Fig. 4.7 (scenario 4: the map as a
/// whole is off) at the noise level that is shown, of the algorithm as published if the experiment has it: the one in
/// the middle of those that fail so. A figure is left out if no seed fails so; other experiments have none.
std::vector<Representative> representative_failures(const Results& results);

}  // namespace waymark::paper
