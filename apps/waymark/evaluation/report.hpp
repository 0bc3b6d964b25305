// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/waymark/evaluation/consistency.hpp"
#include "apps/waymark/evaluation/innovations.hpp"
#include "apps/waymark/evaluation/landmark_error.hpp"
#include "apps/waymark/evaluation/outages.hpp"
#include "apps/waymark/evaluation/relations.hpp"
#include "apps/waymark/evaluation/trajectory_error.hpp"
#include "apps/waymark/evaluation/voxel_error.hpp"

namespace waymark::evaluation {

/// What one call of `waymark evaluate` found, with the options it was found under.
struct Report {
  std::optional<TrajectoryError> trajectory;
  TrajectoryOptions trajectory_options;
  std::optional<Consistency> consistency;
  std::optional<Consistency> spatial_consistency;  ///< of all six of the pose
  std::optional<std::vector<OutageError>> outages;
  OutageOptions outage_options;
  std::optional<RelationScore> relations;
  RelationOptions relation_options;
  std::optional<std::vector<InnovationScore>> innovations;
  std::optional<LandmarkError> landmarks;
  LandmarkOptions landmark_options;
  std::optional<VoxelError> voxels;
};

/// A table for people; ends with a newline.
std::string to_text(const Report& report);

/// One JSON object on one line, ends with a newline: all numbers, keys in snake_case with units, null where there is
/// none.
std::string to_json(const Report& report);

}  // namespace waymark::evaluation
