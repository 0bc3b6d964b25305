// SPDX-License-Identifier: Apache-2.0
#include "waymark/math/so3.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "waymark/math/random.hpp"

namespace waymark::so3 {
namespace {

constexpr double kPi = std::numbers::pi;

Eigen::Vector3d draw(Random& random, double length) {
  Eigen::Vector3d v(random.normal(), random.normal(), random.normal());
  return length * v.normalized();
}

/// Rotation vectors of every size, from nothing to almost half a turn, and beside the switch to the series.
std::vector<Eigen::Vector3d> rotation_vectors() {
  Random random({.seed = 7, .slot = 0, .stamp = 0, .sensor = 0});
  std::vector<Eigen::Vector3d> vectors{Eigen::Vector3d::Zero()};
  for (const double length :
       {1e-12, 1e-8, 1e-5, 9.9e-5, 1.01e-4, 1e-3, 0.0999, 0.1001, 0.5, 1.0, 2.0, 3.0, kPi - 1e-3, kPi - 1e-7}) {
    for (int i = 0; i < 5; ++i) vectors.push_back(draw(random, length));
  }
  return vectors;
}

TEST(So3, SkewIsTheCrossProduct) {
  const Eigen::Vector3d a(1.0, -2.0, 3.0);
  const Eigen::Vector3d b(0.5, 4.0, -1.0);
  EXPECT_TRUE((skew(a) * b).isApprox(a.cross(b), 1e-15));
  EXPECT_TRUE(skew(a).transpose().isApprox(-skew(a)));
}

TEST(So3, LogInvertsExp) {
  for (const Eigen::Vector3d& theta : rotation_vectors()) {
    EXPECT_LT((log(exp(theta)) - theta).norm(), 1e-12 + 1e-9 * theta.norm()) << theta.transpose();
  }
}

TEST(So3, ExpAgreesWithAngleAxis) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1.0, 2.0, -3.0).normalized();
  const Eigen::Matrix3d expected = Eigen::AngleAxisd(1.2, axis).toRotationMatrix();
  EXPECT_TRUE(exp(1.2 * axis).toRotationMatrix().isApprox(expected, 1e-14));
}

TEST(So3, ExpOfTheNegativeIsTheInverse) {
  for (const Eigen::Vector3d& theta : rotation_vectors()) {
    EXPECT_LT(log(exp(theta) * exp(-theta)).norm(), 1e-14);
  }
}

TEST(So3, LogTakesTheShorterWay) {
  const Eigen::Quaterniond q = exp({0.0, 0.0, 0.75 * kPi});
  const Eigen::Quaterniond negative(-q.w(), -q.x(), -q.y(), -q.z());
  EXPECT_LT((log(negative) - log(q)).norm(), 1e-14);
  EXPECT_NEAR(log(exp({0.0, 0.0, 1.5 * kPi})).z(), -0.5 * kPi, 1e-12);
}

TEST(So3, LogOfHalfATurnHasLengthPi) { EXPECT_NEAR(log(Eigen::Quaterniond(0.0, 0.6, 0.0, 0.8)).norm(), kPi, 1e-12); }

TEST(So3, LeftJacobianMatchesDifferences) {
  constexpr double kStep = 1e-6;
  for (const Eigen::Vector3d& theta : rotation_vectors()) {
    if (theta.norm() > 3.1) continue;  // a difference across pi jumps
    const Eigen::Matrix3d J = left_jacobian(theta);
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(i);
      const Eigen::Vector3d difference = log(exp(theta + step) * exp(theta - step).conjugate()) / (2.0 * kStep);
      EXPECT_LT((J.col(i) - difference).norm(), 1e-6) << theta.transpose();
    }
  }
}

TEST(So3, LeftJacobianTurnsItsOwnAxisIntoItself) {
  for (const Eigen::Vector3d& theta : rotation_vectors())
    EXPECT_LT((left_jacobian(theta) * theta - theta).norm(), 1e-12);
}

TEST(So3, DerivativeOfTheLeftJacobianMatchesDifferences) {
  constexpr double kStep = 1e-5;
  const Eigen::Vector3d a(1.3, -0.4, 0.7);
  for (const Eigen::Vector3d& theta : rotation_vectors()) {
    const Eigen::Matrix3d D = left_jacobian_times_vector_derivative(theta, a);
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(i);
      const Eigen::Vector3d difference =
          (left_jacobian(theta + step) * a - left_jacobian(theta - step) * a) / (2.0 * kStep);
      EXPECT_LT((D.col(i) - difference).norm(), 1e-6) << theta.transpose();
    }
  }
}

TEST(So3, SeriesAndClosedFormsMeet) {
  const Eigen::Vector3d axis = Eigen::Vector3d(3.0, -1.0, 2.0).normalized();
  const Eigen::Vector3d a(1.0, 2.0, 3.0);
  const Eigen::Vector3d below = (0.1 - 1e-13) * axis;
  const Eigen::Vector3d above = (0.1 + 1e-13) * axis;
  EXPECT_LT((left_jacobian(below) - left_jacobian(above)).norm(), 1e-12);
  EXPECT_LT((left_jacobian_times_vector_derivative(below, a) - left_jacobian_times_vector_derivative(above, a)).norm(),
            1e-11);
}

TEST(So3, RollPitchYawComeBack) {
  for (const double yaw_angle : {-3.0, 0.0, 2.5}) {
    for (const double pitch : {-1.4, 0.0, 0.8}) {
      const Eigen::Vector3d rpy = to_rpy(from_rpy(-2.0, pitch, yaw_angle));
      EXPECT_LT((rpy - Eigen::Vector3d(-2.0, pitch, yaw_angle)).norm(), 1e-12);
    }
  }
}

TEST(So3, RollPitchYawTurnInTheNamedOrder) {
  const Eigen::Vector3d nose = from_rpy(0.3, -0.2, 0.5 * kPi) * Eigen::Vector3d::UnitX();
  EXPECT_NEAR(nose.x(), 0.0, 1e-15);
  EXPECT_NEAR(nose.z(), std::sin(0.2), 1e-15);
}

TEST(So3, LookingStraightUpStillGivesTheSameRotation) {
  const Eigen::Quaterniond q = from_rpy(0.4, 0.5 * kPi, 1.0);
  const Eigen::Vector3d rpy = to_rpy(q);
  EXPECT_LT(q.angularDistance(from_rpy(rpy.x(), rpy.y(), rpy.z())), 1e-7);
}

TEST(So3, YawIsTheHeadingOfTheNose) {
  EXPECT_NEAR(yaw(from_rpy(0.2, -0.3, 2.0)), 2.0, 1e-14);
  EXPECT_NEAR(yaw(exp({0.0, 0.0, 0.5 * kPi})), 0.5 * kPi, 1e-14);
}

TEST(So3, WrapStaysWithinHalfATurn) {
  EXPECT_DOUBLE_EQ(wrap(kPi), kPi);
  EXPECT_DOUBLE_EQ(wrap(-kPi), kPi);
  EXPECT_NEAR(wrap(3.0 * kPi + 0.25), -kPi + 0.25, 1e-14);
  EXPECT_NEAR(wrap(-100.0), -100.0 + 32.0 * kPi, 1e-12);
  EXPECT_EQ(wrap(0.5), 0.5);
}

}  // namespace
}  // namespace waymark::so3
