// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "apps/waymark/evaluation/outages.hpp"

namespace waymark::paper {

/// What the outages of one drive did to the EKF.
struct OutageTrial {
  double position_rms_m = 0.0;
  double yaw_rms_rad = 0.0;
  double nees_mean = 0.0;  ///< of (x, y, yaw); 3 is right
  std::vector<evaluation::OutageError> outages;
};

/// Figs. 3.1 and 3.2 of the paper: the EKF alone through several short outages of the GPS, over seeds.
struct Outages {
  std::string command;  ///< that makes the page
  std::string config;
  std::vector<std::string> overrides;
  std::vector<std::uint64_t> seeds;
  std::vector<OutageTrial> trials;  ///< by seed

  /// Runs one seed; where `pictures` is not empty, the plots of the YAML go there. Throws Error.
  void run(std::size_t seed, const std::filesystem::path& pictures);
};

/// The page in Markdown. Pictures are expected in `pictures`, relative to the page.
std::string to_page(const Outages& results, const std::string& pictures);

/// Every figure of every trial, as JSON.
std::string to_json(const Outages& results);

}  // namespace waymark::paper
