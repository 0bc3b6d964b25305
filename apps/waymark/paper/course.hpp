// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "apps/waymark/evaluation/association_error.hpp"
#include "apps/waymark/evaluation/landmark_error.hpp"
#include "apps/waymark/evaluation/trajectory_error.hpp"
#include "apps/waymark/paper/scenarios.hpp"
#include "waymark/host/session.hpp"
#include "waymark/interface/source.hpp"

namespace waymark::paper {

/// What one scenario made of one course.
struct Trial {
  double position_rms_m = 0.0;  ///< of the weighted mean at the scans, before the scan's own sampling
  double yaw_rms_rad = 0.0;
  double path_rms_m = 0.0;  ///< of the best particle's path at the end of the run
  double position_end_m = 0.0;
  double nees_mean = 0.0;       ///< of (x, y, yaw) at the scans; 3 is right
  double widest_sigma_m = 0.0;  ///< largest σ of the position in any direction, over the course
  evaluation::LandmarkError landmarks;
  evaluation::AssociationError associations;

  /// Every cylinder once and nothing else.
  bool has_exact_map() const {
    return landmarks.counted == landmarks.surveyed && landmarks.matched == landmarks.surveyed;
  }
};

/// One seed at one noise level: the simulator's measurements, made once, go to all scenarios.
struct Course {
  std::uint64_t seed;
  double noise;                    ///< factor on the odometry's noise, of simulator and filter
  std::filesystem::path pictures;  ///< folder for the pictures of the scenarios; empty: none
};

/// Runs the scenarios on a course: the source of the first feeds them all. `overrides` are applied to all. Throws
/// Error, also if a plugin goes out of service: such a run is not a result.
std::vector<Trial> run(const std::filesystem::path& config, const std::vector<std::string>& overrides,
                       const Course& course, const std::vector<Scenario>& scenarios);

/// The ground truth of the source. Throws Error if it has none.
evaluation::Trajectory truth_of(const Source& source);

/// Throws Error if anything went wrong in a run: then it is not a result.
void refuse_failures(const host::SessionResult& result);

/// The world that all courses have in common.
std::vector<evaluation::Landmark> surveyed(const std::filesystem::path& config,
                                           const std::vector<std::string>& overrides);

}  // namespace waymark::paper
