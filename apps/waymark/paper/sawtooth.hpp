// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "apps/waymark/paper/course.hpp"
#include "apps/waymark/paper/scenarios.hpp"

namespace waymark::paper {

/// What a GPS does to SLAM: the paper's open question on the sawtooth of Fig. 3.2. Every GPS goes to the filter of the
/// paper, to one with the slowly varying error as states of its own, and to one with the map's place on the Earth as
/// states, each with one particle and with 25.
struct Sawtooth {
  /// One GPS; a rate of 0 stands for none.
  struct Gps {
    double rate_hz;
    double correlated_m;  ///< σ of the slowly varying error, each axis
  };

  std::string command;  ///< that makes the page
  std::string config;
  std::vector<std::string> overrides;
  double noise = 1.0;  ///< factor on the odometry's noise, in simulator and filter
  std::vector<std::uint64_t> seeds;
  std::vector<Gps> gps;                                 ///< the first is none
  std::vector<std::vector<std::vector<Trial>>> trials;  ///< by GPS, seed, scenario

  static constexpr double kRates[] = {0.2, 0.5, 1.0, 2.0, 5.0};
  static constexpr double kErrors[] = {0.0, 0.5, 1.0, 2.0};

  /// All GPS, and room for the trials of `seeds` seeds.
  static Sawtooth prepare(int seeds);
  /// The filters that meet one GPS, each with 1 and with 25 particles.
  static std::vector<Scenario> scenarios(const Gps& gps);
  /// Runs one seed with one GPS.
  void run(const std::string& file, std::size_t which, std::size_t seed);
};

/// The page in Markdown.
std::string to_page(const Sawtooth& results);

/// Every figure of every trial, as JSON.
std::string to_json(const Sawtooth& results);

}  // namespace waymark::paper
