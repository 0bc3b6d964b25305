// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "apps/waymark/paper/course.hpp"

namespace waymark::paper {

/// All that `waymark paper` has measured.
struct Results {
  std::string command;  ///< that makes this page
  std::string config;
  std::vector<std::string> overrides;
  std::vector<evaluation::Landmark> world;
  std::vector<Scenario> scenarios;
  std::vector<std::uint64_t> seeds;
  std::vector<double> noises;
  std::vector<std::vector<std::vector<Trial>>> trials;  ///< by noise, seed, scenario
};

/// The page in Markdown: world, figures, a table per noise level, the sweep. Pictures are expected in `pictures`,
/// relative to the page.
std::string to_page(const Results& results, const std::string& pictures);

/// Every figure of every trial, as JSON.
std::string to_json(const Results& results);

}  // namespace waymark::paper
