// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "apps/waymark/evaluation/report.hpp"

namespace waymark::command {

/// The command line of `waymark evaluate`. Empty texts and lists: not given.
struct EvaluateOptions {
  std::vector<std::string> runs;  // output folders
  std::string estimate;
  std::string reference;
  std::string covariance;
  std::string diagnostics;
  std::vector<std::string> outages;
  std::string pauses_of;
  double pauses_longer_than_s = 0.0;  // 0: not given
  std::string relations;
  std::string relations_motion;
  std::vector<double> relations_sensor;  // x, y [m] and perhaps yaw [deg]
  std::string landmarks;
  std::string survey;
  std::string voxels;
  std::string surfaces;
  std::string columns;
  std::string reference_columns;
  std::string survey_columns;
  std::string align = "none";
  std::vector<double> lever_arm_m;
  double reference_sigma_m = 0.0;
  std::vector<double> datum;
  double rpe_delta_s = 0.0;  // 0: not given
  std::string overlay;
  bool json = false;
  evaluation::TrajectoryOptions trajectory;
  evaluation::LandmarkOptions landmark;
  evaluation::OutageOptions outage;
  evaluation::VoxelOptions voxel;
};

/// Adds all options to the subcommand; `options` must outlive it.
void add_evaluate_options(CLI::App* command, EvaluateOptions& options);

/// Refuses options that mean nothing without others. Throws UsageError.
void require_consistent(const EvaluateOptions& options);

}  // namespace waymark::command
