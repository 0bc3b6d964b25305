// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/calibration/iron.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <random>

#include "apps/waymark/calibration/magnetometer.hpp"

namespace waymark::calibration {
namespace {

const Eigen::Vector3d kEarth(2e-5, 0.0, -4.4e-5);  // [T]
const Eigen::Vector3d kHard(8e-6, -5e-6, 3e-6);
constexpr double kNoise = 3e-7;

/// Symmetric, of determinant 1 in x and y.
Eigen::Matrix3d soft_of(double stretch) {
  Eigen::Matrix3d soft = Eigen::Matrix3d::Identity();
  const Eigen::Rotation2Dd turned(0.4);
  soft.topLeftCorner<2, 2>() = turned.toRotationMatrix() * Eigen::Vector2d(stretch, 1.0 / stretch).asDiagonal() *
                               turned.inverse().toRotationMatrix();
  return soft;
}

Eigen::Vector3d reading(const Eigen::Matrix3d& soft, const Eigen::Quaterniond& attitude, std::mt19937& random) {
  std::normal_distribution<double> normal;
  const Eigen::Vector3d noise(normal(random), normal(random), normal(random));
  return soft.inverse() * (attitude.inverse() * kEarth) + kHard + kNoise * noise;
}

/// A robot that stays level and turns from 0 to `turn` in equal steps, there and back.
std::vector<Eigen::Vector3d> level(double turn, const Eigen::Matrix3d& soft, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Eigen::Vector3d> fields;
  for (int k = 0; k < 2000; ++k) {
    const double yaw = turn * std::abs(std::remainder(k / 500.0, 2.0));
    fields.push_back(reading(soft, Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ())), random));
  }
  return fields;
}

TEST(CalibrationIron, ALevelRobotThatTurnsRound) {
  const Eigen::Matrix3d soft = soft_of(1.08);
  int within = 0;
  for (unsigned seed = 1; seed <= 25; ++seed) {
    const std::optional<Iron> iron = fit_iron(level(2.0 * std::numbers::pi, soft, seed));
    ASSERT_TRUE(iron);
    ASSERT_EQ(iron->axes, 2);
    EXPECT_LT(iron->gap_rad, 0.1);
    EXPECT_LT(iron->hard_sigma.maxCoeff(), 2e-8);
    EXPECT_EQ(iron->hard.z(), 0.0) << "not excited";
    EXPECT_NEAR(iron->strength, kEarth.head<2>().norm(), 0.01 * kEarth.head<2>().norm());
    EXPECT_LT((iron->soft - soft).cwiseAbs().maxCoeff(), 5.0 * iron->soft_sigma);
    EXPECT_LT(iron->soft_sigma, 0.002);
    for (int axis : {0, 1}) within += std::abs(iron->hard(axis) - kHard(axis)) < 2.0 * iron->hard_sigma(axis) ? 1 : 0;
  }
  EXPECT_GE(within, 42) << "of 50; 47.7 are expected";
}

TEST(CalibrationIron, AllAttitudesDetermineAllAxes) {
  std::mt19937 random(3);
  Eigen::Matrix3d soft;
  soft << 1.05, 0.02, -0.01, 0.02, 0.97, 0.03, -0.01, 0.03, 1.0;
  soft /= std::cbrt(soft.determinant());
  std::vector<Eigen::Vector3d> fields;
  std::normal_distribution<double> normal;
  for (int k = 0; k < 2000; ++k) {
    const Eigen::Vector4d q(normal(random), normal(random), normal(random), normal(random));
    fields.push_back(reading(soft, Eigen::Quaterniond(q.normalized()), random));
  }
  const std::optional<Iron> iron = fit_iron(fields);
  ASSERT_TRUE(iron);
  EXPECT_EQ(iron->axes, 3);
  EXPECT_LT((iron->hard - kHard).norm(), 1e-7);
  EXPECT_LT((iron->soft - soft).cwiseAbs().maxCoeff(), 0.003);
  EXPECT_NEAR(iron->strength, kEarth.norm(), 1e-7);
  EXPECT_LT(iron->scatter, 0.01);
}

TEST(CalibrationIron, AQuarterTurnDeterminesNothing) {
  const std::optional<Iron> iron = fit_iron(level(0.5 * std::numbers::pi, soft_of(1.0), 1));
  Magnetometer magnetometer;
  if (iron) magnetometer.iron = *iron;
  EXPECT_TRUE(!iron || !magnetometer.is_determined());
}

TEST(CalibrationIron, ASteelPlateOnTheWayDoesNotBendTheRest) {
  std::vector<Eigen::Vector3d> fields = level(2.0 * std::numbers::pi, soft_of(1.05), 2);
  for (std::size_t k = 300; k < 380; ++k) fields[k] += Eigen::Vector3d(1.5e-5, 1e-5, 0.0);
  const std::optional<Iron> iron = fit_iron(fields);
  ASSERT_TRUE(iron);
  EXPECT_LT((iron->hard - kHard).head<2>().norm(), 2e-7);
  EXPECT_LT((iron->soft - soft_of(1.05)).cwiseAbs().maxCoeff(), 0.02);
}

TEST(CalibrationIron, NoFit) {
  EXPECT_FALSE(fit_iron({}));
  EXPECT_FALSE(fit_iron(std::vector<Eigen::Vector3d>(100, kEarth))) << "one point";
}

}  // namespace
}  // namespace waymark::calibration
