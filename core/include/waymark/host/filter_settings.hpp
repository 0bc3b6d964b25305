// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <numbers>

#include "waymark/base/time.hpp"

namespace waymark {

/// White acceleration noise as densities: σ of the velocity after one second.
struct ProcessNoise {
  Eigen::Vector3d velocity_per_sqrt_s{1.0, 0.3, 0.3};  ///< base x, y, z [m/s/√s]
  Eigen::Vector3d rate_per_sqrt_s{0.5, 0.5, 1.0};      ///< base x, y, z [rad/s/√s]
};

/// Estimation of the map's place on the Earth, and its random walk (`georeference:` of the YAML).
struct GeoreferenceSettings {
  bool enabled = true;
  double position_walk_per_sqrt_m = 0.02;  ///< drift of a growing SLAM map against the Earth [m/√m driven]
  double yaw_walk_per_sqrt_m = 0.0;        ///< [rad/√m driven]
};

/// The joint Gaussian over the pose and the places of the maps, whose covariance is reported (`joint:` of the YAML).
struct JointSettings {
  bool enabled = true;
  double anchor_spacing = 4.0;                               ///< distance between the anchors of a dense map [m]
  double anchor_sigma = 0.015;                               ///< error that all places of an anchor have in common [m]
  double anchor_yaw_sigma = 0.4 * std::numbers::pi / 180.0;  ///< [rad]
};

/// Places that are met again, and the correction of the maps between (`loops:` of the YAML).
struct LoopSettings {
  bool enabled = true;            ///< with maps that can be drawn again, all of them begun by this run
  double least_way = 30.0;        ///< on which a place counts as met again [m]
  double search_distance = 20.0;  ///< half width of the search, at most [m]
  double search_angle = 15.0 * std::numbers::pi / 180.0;  ///< [rad]
  double least_shift = 0.15;  ///< the maps are drawn again where a loop moves them farther than this [m]
};

/// The search for a robot that is not where it is believed to be in a loaded map (`relocation:` of the YAML).
struct RelocationSettings {
  bool enabled = true;  ///< with a dense map that was loaded, and no absolute sensor that is fused
};

/// The particle filter's part of the YAML (`filter:`).
struct ParticleFilterSettings {
  int particles = 1;
  std::uint64_t seed = 1;
  double resample_threshold = 0.5;  ///< resample when N_eff < threshold × particles
  /// a: 1 samples the whole pose (the paper), less keeps 1 − a as covariance.
  double sampling_fraction = 0.2;
  int threads = 1;
  std::size_t path_poses = 200'000;  ///< >= 2; of a longer path the older half loses every second pose
  JointSettings joint;
  LoopSettings loops;
  RelocationSettings relocation;
  Duration history{};  ///< past beliefs stored for late measurements reach back this far; zero: none
  /// No sensor and no loaded map says where the start pose lies: where the maps are begun is as good as any other
  /// place.
  bool maps_begin_anywhere = false;
};

}  // namespace waymark
