// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>

namespace waymark::particles {

/// Notices that matches and motion contradict each other: over many mapping steps most matches lie beyond what the
/// motion expects, all to the same side. So a map of two dimensions holds a robot that drives up a ramp. Where the
/// noise of the wheels is too small for them, matches jump to all sides.
class JumpWatch {
 public:
  /// Adds a mapping step: how far its match lies from the prior mean, in the base's axes and in σ of the prior; zero if
  /// the prior expects it.
  void add(const Eigen::Vector3d& jump) {
    steps_ = std::min(steps_ + 1.0, kWindow);
    const double share = 1.0 / steps_;
    const double length = jump.norm();
    jumped_ += share * ((length > 0.0 ? 1.0 : 0.0) - jumped_);
    mean_ += share * (jump - mean_);
    mean_length_ += share * (length - mean_length_);
  }
  bool is_one_sided() const {
    return steps_ >= kWindow && jumped_ > kMostJump && mean_.norm() > kOneSided * mean_length_;
  }

  template <class Archive>
  void serialize(Archive& archive) {
    archive(steps_, jumped_, mean_, mean_length_);
  }

 private:
  static constexpr double kWindow = 20.0;  // mapping steps
  static constexpr double kMostJump = 0.6;
  static constexpr double kOneSided =
      0.95;  // length of the mean jump by the mean length: 0.99 on a ramp, 0.84 on right maps

  double steps_ = 0.0;
  double jumped_ = 0.0;
  Eigen::Vector3d mean_ = Eigen::Vector3d::Zero();
  double mean_length_ = 0.0;
};

}  // namespace waymark::particles
