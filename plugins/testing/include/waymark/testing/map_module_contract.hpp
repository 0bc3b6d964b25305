// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "waymark/interface/map_module.hpp"
#include "waymark/testing/keys_contract.hpp"
#include "waymark/testing/violations.hpp"

namespace waymark::testing {

/// One mapping step as the host would make it.
struct MappingStep {
  Measurement trigger;  ///< of the module's first input
  Pose T_map_base;      ///< where the robot was
  std::vector<std::pair<std::string, Measurement>> companions =
      {};  ///< input and measurement; a null payload: none that is fresh enough
  MotionWindow motion = {};
};

/// A mapping step for each of the triggers, at the places of a robot that drives along x at `speed_m_s` from 0.
std::vector<MappingStep> straight_drive(std::span<const Measurement> triggers, double speed_m_s);

/// Covariances of (x [m], y [m], yaw [rad]) under which a map is checked.
struct MapSetting {
  Eigen::Matrix3d prior =
      Eigen::Vector3d(0.01, 0.01, 1e-4).asDiagonal();  ///< before a step; zero and ten times as much are tried, too
  Eigen::Matrix3d kept = Eigen::Vector3d(0.002, 0.002, 2e-5).asDiagonal();  ///< what sampling leaves, at `insert`
};

/// Drives the module through `steps` (in stamp order, about 10 to 100) and checks
/// - `extract`: deterministic, also after the module's own `save` and `load`; a foreign payload is refused with
/// DataError;
/// - `refine`: leaves the map alone, is deterministic, also with an association that an earlier step used and from
/// several
///   threads on clones; information symmetric and positive semi-definite, all values finite, also for a prior without
///   covariance;
/// - `clone` and `insert`: deterministic; writing one map leaves its clones as they were, both ways;
/// - `save` and `load_map`: same bytes when saved again, same description, same refinement, identical continuation;
/// maps that share storage
///   in one archive; a stream that ends early is refused;
/// - an empty map works; `describe` gives finite values, positive semi-definite covariances, each id once.
/// The module's own state is the one it came with when this returns.
Violations check_map_module(MapModule& module, std::span<const MappingStep> steps, const MapSetting& setting = {});

/// The same for class Module, built from `yaml`, its mapping in a robot's YAML, after `check_keys`.
template <class Module>
Violations check_map_module(const std::string& yaml, const Rig& rig, std::span<const MappingStep> steps,
                            const MapSetting& setting = {}) {
  Violations found = check_keys<Module>(yaml, rig);
  Module module(Config::parse(yaml), rig);
  for (std::string& violation : check_map_module(module, steps, setting)) found.push_back(std::move(violation));
  return found;
}

}  // namespace waymark::testing
