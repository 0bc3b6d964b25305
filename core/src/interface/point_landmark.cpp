// SPDX-License-Identifier: Apache-2.0
#include "waymark/interface/point_landmark.hpp"

#include <Eigen/LU>
#include <limits>

#include "waymark/math/gaussian.hpp"

namespace waymark {

namespace {

/// Where a sighting lies in the map, and how that changes with (x, y, yaw).
struct Sight {
  Sight(const Pose& T_map_base, const Eigen::Vector3d& p_base) {
    const Eigen::Vector2d p = (T_map_base * p_base).head<2>();
    const Eigen::Vector2d arm = p - T_map_base.p.head<2>();
    p_map = p;
    G << 1.0, 0.0, -arm.y(), 0.0, 1.0, arm.x();
  }
  Eigen::Vector2d p_map;
  Eigen::Matrix<double, 2, 3> G;
};

}  // namespace

void PointLandmark::match(const PoseGaussian& prior, const Eigen::Vector3d& p_base, const Eigen::Matrix2d& R,
                          Refinement& out) const {
  if (sightings == 0) return;
  const Sight sight(prior.T_map_base, p_base);
  const Eigen::Matrix2d noise = P + R;
  const Eigen::Matrix2d weight = noise.inverse();
  const Eigen::Vector2d nu = p_map - sight.p_map;
  // The prior with what is in `out`: P (I + Λ P)⁻¹, which exists for a singular P, too.
  const Eigen::Matrix3d refined = prior.P * (Eigen::Matrix3d::Identity() + out.information * prior.P).inverse();
  const Eigen::Vector2d innovation = nu - sight.G * (refined * out.gradient);
  const Eigen::Matrix2d S = sight.G * refined * sight.G.transpose() + noise;
  out.log_evidence += gaussian::density(innovation, S).log_density;
  out.information += sight.G.transpose() * weight * sight.G;
  out.gradient += sight.G.transpose() * weight * nu;
}

void PointLandmark::fuse(const PoseGaussian& pose, const Eigen::Vector3d& p_base, const Eigen::Matrix2d& R) {
  const Sight sight(pose.T_map_base, p_base);
  const Eigen::Matrix2d noise = R + sight.G * pose.P * sight.G.transpose();
  if (sightings++ == 0) {
    p_map = sight.p_map;
    P = noise;
    return;
  }
  const Eigen::Matrix2d K = P * (P + noise).inverse();
  p_map += K * (sight.p_map - p_map);
  P -= K * P;
  P = (0.5 * (P + P.transpose())).eval();
}

LandmarkView PointLandmark::view() const {
  LandmarkView view;
  view.p_map = p_map;
  view.radius_m = std::numeric_limits<double>::quiet_NaN();
  view.P.topLeftCorner<2, 2>() = P;
  view.existence = 1.0;
  view.sightings = sightings;
  view.confirmed = true;
  return view;
}

void PointLandmark::describe(MapDescription& out) const {
  if (sightings > 0) out.landmarks.push_back(view());
}

}  // namespace waymark
