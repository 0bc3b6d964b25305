// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "waymark/base/api.hpp"
#include "waymark/interface/snapshot.hpp"

namespace waymark {

/// One of several separate places and headings at which the particles have the robot.
struct PoseMode {
  Pose T_map_base;  ///< of its heaviest particle
  double weight;    ///< of its particles together; all modes have at least `ModeFinder::kLeastWeight`
};

/// Finds out whether the mixture of the particles has more than one mode. Along the direction in which poses (x, y, and
/// the heading times 3 m) are spread most, particles are cut in two where Ashman's D = √2 |μ₁ − μ₂| / √(σ₁² + σ₂²)
/// (K. M. Ashman et al., 1994) is largest. Of n particles D > 5 (1 + 8 / n) makes two modes, with a σ of at least
/// 0.06 m: of draws of a Gaussian or a uniform spread hardly one in a hundred has so large a D. Each of both is cut
/// again. Holds the storage that this takes.
class WAYMARK_API ModeFinder {
 public:
  static constexpr double kLeastD = 5.0;        ///< of many particles
  static constexpr double kFew = 8.0;           ///< particles of which D must be twice as large
  static constexpr double kLeastSigma = 0.06;   ///< [m]
  static constexpr double kLeastWeight = 0.12;  ///< of a mode
  static constexpr double kHeadingArm = 3.0;    ///< [m], by which a heading counts

  /// The modes, heaviest first. Never more than 1 / `kLeastWeight`, one for unimodal particles, none for no particles.
  /// Valid until the next call.
  const std::vector<PoseMode>& find(std::span<const ParticleView> particles);

  /// False if particles whose poses (x, y, yaw) have a covariance of P have one mode: they are too near to one another.
  static bool may_have_modes(const Eigen::Matrix3d& P) {
    return P(0, 0) + P(1, 1) + kHeadingArm * kHeadingArm * P(2, 2) >= kLeastVariance;
  }

 private:
  // Two modes that are apart by d, of weights w and 1 - w, have a variance of w (1 - w) d².
  static constexpr double kLeastVariance =
      kLeastWeight * (1.0 - kLeastWeight) * kLeastD * kLeastSigma * kLeastD * kLeastSigma;

  struct Point {
    Eigen::Vector3d at;  // x, y, heading · arm
    double weight;
    double along;  // the direction of the greatest spread
    std::size_t particle;
  };
  void divide(std::span<Point> points, std::span<const ParticleView> particles);
  static std::size_t cut(std::span<Point> points);

  std::vector<Point> points_;
  std::vector<PoseMode> modes_;
};

}  // namespace waymark
