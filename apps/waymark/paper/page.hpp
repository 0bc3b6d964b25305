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
  Experiment experiment;
  std::vector<std::uint64_t> seeds;
  std::vector<double> noises;
  std::vector<std::vector<std::vector<Trial>>> trials;  ///< by noise, seed, scenario
};

/// The noise level that is shown in full, with pictures of the first seed: × 1, or the first one given.
std::size_t shown_noise(const Results& results);

/// The page in Markdown: figures, filters side by side, a table and a sweep per filter, world. Pictures are expected in
/// `pictures`, relative to the page.
std::string to_page(const Results& results, const std::string& pictures);

/// Every figure of every trial, as JSON.
std::string to_json(const Results& results);

}  // namespace waymark::paper
