// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <numbers>

#include "waymark/base/time.hpp"

namespace waymark {

/// White acceleration noise as densities: how far a velocity may wander in a second.
struct ProcessNoise {
  Eigen::Vector3d velocity_per_sqrt_s{1.0, 0.3, 0.3};  ///< base x, y, z [m/s/√s]
  Eigen::Vector3d rate_per_sqrt_s{0.5, 0.5, 1.0};      ///< base x, y, z [rad/s/√s]
};

/// Whether the map's place on the Earth is estimated, and how it may wander.
struct GeoreferenceSettings {
  bool enabled = true;
  double position_walk_per_sqrt_m = 0.02;  ///< a SLAM map drifts against the Earth while it grows [m/√m driven]
  double yaw_walk_per_sqrt_m = 0.0;        ///< [rad/√m driven]
};

/// The particle filter's part of the YAML (`filter:`).
struct ParticleFilterSettings {
  int particles = 1;
  std::uint64_t seed = 1;
  double resample_threshold = 0.5;  ///< resample when N_eff < threshold × particles
  /// a: 1 samples the whole pose (the paper), less keeps 1 − a as covariance.
  double sampling_fraction = 0.2;
  int threads = 1;
  Duration history{};  ///< how far back the beliefs are kept, for late measurements; zero: not at all
};

}  // namespace waymark
