// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "waymark/interface/payloads.hpp"
#include "waymark/math/random.hpp"

namespace waymark::radar {

/// Noise of a radar, and when a scan is believed.
struct ScanSettings {
  int dimensions = 2;                ///< 2: planar radar, elevations are not used; 3: v_z is estimated, too
  double doppler_sigma_mps = 0.0;    ///< white noise of a radial velocity
  double azimuth_sigma_rad = 0.0;    ///< white noise of an azimuth in front; of a phased array it grows with 1/cos
  double elevation_sigma_rad = 0.0;  ///< the same of an elevation, with 3 dimensions
  double correlation = 0.0;          ///< of the errors of two targets of a scan
  double scan_sigma_mps = 0.0;       ///< error of the velocity that all targets of a scan share, per axis
  double scan_sigma_rad = 0.0;       ///< error of the angles that they share
  double gate_sigma = 0.0;           ///< a target whose residual exceeds so many of its σ moves by itself
  int draws = 0;                     ///< of RANSAC
  double min_range_m = 0.0;          ///< nearer targets are not used
  std::size_t min_inliers = 0;       ///< so many targets must agree, and
  double min_share = 0.0;            ///< such a share of the targets that are used
};

/// Velocity of the radar over ground in its own frame, from one scan.
struct EgoVelocity {
  Eigen::Vector3d v = Eigen::Vector3d::Zero();       ///< [m/s]; z is 0 with two dimensions
  Eigen::Matrix3d white = Eigen::Matrix3d::Zero();   ///< its covariance by errors of single targets [m²/s²]
  Eigen::Matrix3d shared = Eigen::Matrix3d::Zero();  ///< by errors that targets share: they stay for a while
  std::size_t used = 0;                              ///< targets far enough away
  std::size_t inliers = 0;                           ///< of these, targets that stand still

  double share() const { return used == 0 ? 0.0 : static_cast<double>(inliers) / static_cast<double>(used); }
};

/// Ego velocity from Doppler. A target that stands still in the direction u recedes with −u·v, so each gives one linear
/// equation (D. Kellner et al., "Instantaneous ego-motion estimation using Doppler radar", ITSC 2013; with three
/// dimensions C. Doer, G. F. Trommer, "An EKF based approach to radar inertial odometry", MFI 2020).
///
/// The set of targets that stand still is found by random sampling: candidates of two (three) targets, scored by a
/// truncated log-likelihood (P. Torr, A. Zisserman, "MLESAC", 2000). Weighted least squares over that set follow. The
/// variance of a residual is that of the radial velocity plus what the noise of the angles makes of the velocity across
/// the ray: σ² = σ_d² + (σ_az ∂u/∂az·v)² + (σ_el ∂u/∂el·v)². Many targets lie on the same wall, and share errors of
/// angles and of elevation: n of them count as n / (1 + (n − 1) ρ) with their correlation ρ (the design effect of L.
/// Kish, "Survey sampling", 1965), which keeps the shape that the geometry gives the covariance. On top come errors of
/// the whole scan.
class EgoVelocityEstimator {
 public:
  explicit EgoVelocityEstimator(const ScanSettings& settings) : settings_(settings) {}

  /// The velocity with the counts; the counts alone count if `believed` is false. Allocates only for a scan that is
  /// larger than all before.
  EgoVelocity estimate(std::span<const RadarTargets::One> targets, Random random);

  /// True if enough targets agree.
  bool believed(const EgoVelocity& velocity) const;

  /// Of the last scan, by target: 1 if it stands still, 0 if it moves by itself or was too near.
  std::span<const std::uint8_t> stands_still() const { return flags_; }

 private:
  /// A target as a row of the model: radial = −ray·v.
  struct Row {
    Eigen::Vector3d ray;      ///< unit vector
    Eigen::Vector3d azimuth;  ///< ∂ray/∂azimuth · σ
    Eigen::Vector3d elevation;
    double radial_mps;
    std::size_t target;
  };

  void fill_rows(std::span<const RadarTargets::One> targets);
  double variance(const Row& row, const Eigen::Vector3d& v) const;
  std::optional<Eigen::Vector3d> draw_candidate(Random& random) const;
  double cost(const Eigen::Vector3d& v, double abandon_above) const;
  bool refine(EgoVelocity& velocity);

  ScanSettings settings_;
  std::vector<Row> rows_;
  std::vector<std::uint8_t> flags_;
};

}  // namespace waymark::radar
