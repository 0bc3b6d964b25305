// SPDX-License-Identifier: Apache-2.0
#include "waymark/interface/point_landmark.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

namespace waymark {
namespace {

const Eigen::Matrix2d kNoise = Eigen::Vector2d(0.01, 0.04).asDiagonal();

PoseGaussian prior() {
  Eigen::Matrix3d P;
  P << 0.04, 0.01, 0.002, 0.01, 0.09, -0.003, 0.002, -0.003, 0.01;
  return {Pose::planar(1.0, 2.0, 0.3), P};
}

PointLandmark landmark(double x, double y) { return {{x, y}, 0.02 * Eigen::Matrix2d::Identity(), 3}; }

/// What both sightings together say, stacked as one of four rows.
struct Stacked {
  Stacked(const PoseGaussian& pose, const PointLandmark& a, const Eigen::Vector3d& z_a, const PointLandmark& b,
          const Eigen::Vector3d& z_b) {
    const auto rows = [&](int first, const PointLandmark& one, const Eigen::Vector3d& z) {
      const Eigen::Vector2d p = (pose.T_map_base * z).head<2>();
      const Eigen::Vector2d arm = p - pose.T_map_base.p.head<2>();
      G.middleRows<2>(first) << 1.0, 0.0, -arm.y(), 0.0, 1.0, arm.x();
      nu.segment<2>(first) = one.p_map - p;
      W.block<2, 2>(first, first) = one.P + kNoise;
    };
    rows(0, a, z_a);
    rows(2, b, z_b);
    const Eigen::Matrix4d S = G * pose.P * G.transpose() + W;
    log_evidence = -0.5 * (nu.dot(S.inverse() * nu) + std::log((2.0 * M_PI * S).determinant()));
  }
  Eigen::Matrix<double, 4, 3> G;
  Eigen::Vector4d nu;
  Eigen::Matrix4d W = Eigen::Matrix4d::Zero();
  double log_evidence;
};

TEST(PointLandmark, TwoSightingsAreOneOfFourRows) {
  const PointLandmark a = landmark(3.1, 2.9);
  const PointLandmark b = landmark(0.4, 4.2);
  const Eigen::Vector3d z_a(2.2, 0.1, 0.5);
  const Eigen::Vector3d z_b(0.2, 2.1, 0.0);
  Refinement out;
  a.match(prior(), z_a, kNoise, out);
  b.match(prior(), z_b, kNoise, out);
  const Stacked stacked(prior(), a, z_a, b, z_b);
  const Eigen::Matrix4d weight = stacked.W.inverse();
  EXPECT_TRUE(out.information.isApprox(stacked.G.transpose() * weight * stacked.G, 1e-12));
  EXPECT_TRUE(out.gradient.isApprox(stacked.G.transpose() * weight * stacked.nu, 1e-12));
  EXPECT_NEAR(out.log_evidence, stacked.log_evidence, 1e-9);
}

TEST(PointLandmark, ASingularPriorHasAnEvidence) {
  PoseGaussian certain = prior();
  certain.P.setZero();
  Refinement out;
  landmark(3.1, 2.9).match(certain, {2.2, 0.1, 0.0}, kNoise, out);
  landmark(3.1, 2.9).match(certain, {2.2, 0.1, 0.0}, kNoise, out);
  EXPECT_TRUE(std::isfinite(out.log_evidence));
}

TEST(PointLandmark, IsTheMeanOfItsSightings) {
  PoseGaussian pose = prior();
  pose.P.setZero();
  PointLandmark one;
  Refinement nothing;
  one.match(pose, {1.0, 0.0, 0.0}, kNoise, nothing);
  EXPECT_EQ(nothing.log_evidence, 0.0) << "never seen";
  Eigen::Vector2d sum(0.0, 0.0);
  for (const double x : {1.0, 1.4, 0.9, 1.1}) {
    one.fuse(pose, {x, 0.5, 0.0}, kNoise);
    sum += (pose.T_map_base * Eigen::Vector3d(x, 0.5, 0.0)).head<2>();
  }
  EXPECT_EQ(one.sightings, 4);
  EXPECT_TRUE(one.p_map.isApprox(0.25 * sum, 1e-12));
  EXPECT_TRUE(one.P.isApprox(0.25 * kNoise, 1e-12));
  EXPECT_EQ(one.view().sightings, 4);
  EXPECT_TRUE(std::isnan(one.view().radius_m));
}

TEST(PointLandmark, ItsPlaceIsAsUncertainAsThePoseFromWhichItWasSeen) {
  PointLandmark one;
  one.fuse(prior(), {2.0, 0.0, 0.0}, kNoise);
  const Eigen::Matrix2d of_pose = prior().P.topLeftCorner<2, 2>();
  EXPECT_GT(one.P.trace(), kNoise.trace() + of_pose.trace());
}

TEST(PointLandmark, AnObservationOfAPointIsThePoint) {
  const Eigen::Vector3d z(2.2, 0.1, 0.5);
  const PointObservation seen(z);
  PointLandmark by_point = landmark(3.1, 2.9);
  PointLandmark by_observation = by_point;
  Refinement of_point;
  Refinement of_observation;
  by_point.match(prior(), z, kNoise, of_point);
  by_observation.match(prior(), static_cast<const Observation&>(seen), kNoise, of_observation);
  EXPECT_EQ(of_observation.information, of_point.information);
  EXPECT_EQ(of_observation.log_evidence, of_point.log_evidence);
  by_point.fuse(prior(), z, kNoise);
  by_observation.fuse(prior(), static_cast<const Observation&>(seen), kNoise);
  EXPECT_EQ(by_observation.p_map, by_point.p_map);
  EXPECT_EQ(by_observation.sightings, 4);
}

TEST(PointLandmark, IsDescribedOnceItWasSeen) {
  MapDescription description;
  PointLandmark().describe(description);
  EXPECT_TRUE(description.landmarks.empty());
  landmark(3.1, 2.9).describe(description);
  ASSERT_EQ(description.landmarks.size(), 1u);
  EXPECT_EQ(description.landmarks[0].p_map, Eigen::Vector2d(3.1, 2.9));
}

}  // namespace
}  // namespace waymark
