// SPDX-License-Identifier: Apache-2.0
#include "estimation/heading_fit.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "waymark/math/random.hpp"

namespace waymark::estimation {
namespace {

constexpr double kDeg = std::numbers::pi / 180.0;

ReckonedFix fix(double t, const Eigen::Vector2d& p_local, const Eigen::Vector2d& p_map, double sigma = 0.1) {
  ReckonedFix out;
  out.stamp = Time{from_seconds(t)};
  out.p_local = p_local;
  out.p_map = p_map;
  out.sigma_m = sigma;
  return out;
}

/// A quarter of a circle of 5 m, in `count` points, as dead reckoning has it.
std::vector<Eigen::Vector2d> curve(int count) {
  std::vector<Eigen::Vector2d> points;
  for (int k = 0; k < count; ++k) {
    const double turn = 0.5 * std::numbers::pi * k / (count - 1);
    points.emplace_back(5.0 * std::sin(turn), 5.0 * (1.0 - std::cos(turn)));
  }
  return points;
}

Eigen::MatrixXd no_error(std::size_t count) {
  const auto n = static_cast<Eigen::Index>(2 * count);
  return Eigen::MatrixXd::Zero(n, n);
}

TEST(HeadingFit, FindsTheRotationOfACurveFarFromTheOrigin) {
  for (const double yaw : {-3.1, -1.0, 0.0, 0.7, 2.5}) {
    std::vector<ReckonedFix> fixes;
    for (const Eigen::Vector2d& p : curve(8))
      fixes.push_back(fix(p.x(), p, Eigen::Vector2d(5e6, -4e6) + Eigen::Rotation2Dd(yaw) * p));
    const auto fit = fit_heading(fixes, no_error(fixes.size()));
    ASSERT_TRUE(fit);
    EXPECT_NEAR(std::remainder(fit->yaw - yaw, 2.0 * std::numbers::pi), 0.0, 1e-5);
    EXPECT_LT(fit->sigma, 2.0 * kDeg);
  }
}

/// Errors of the fits over many draws, in units of their own σ.
double mean_square_of_errors(double white, double slow, double tau, double reckoned_per_m) {
  constexpr int kRuns = 400;
  const auto points = curve(12);
  double sum = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    Random random({7, static_cast<std::uint32_t>(run), 0, 0});
    std::vector<ReckonedFix> fixes;
    Eigen::Vector2d offset(slow * random.normal(), slow * random.normal());
    // The error of the scale of the path, which all points have in common.
    const double scale = 1.0 + reckoned_per_m * random.normal();
    Eigen::VectorXd by_scale(static_cast<Eigen::Index>(2 * points.size()));
    for (std::size_t k = 0; k < points.size(); ++k) {
      const Eigen::Vector2d p = points[k];
      const Eigen::Vector2d error(white * random.normal(), white * random.normal());
      fixes.push_back(fix(static_cast<double>(k), scale * p, Eigen::Rotation2Dd(1.0) * p + offset + error, white));
      fixes.back().slow_sigma_m = slow;
      fixes.back().slow_tau_s = tau;
      by_scale.segment<2>(static_cast<Eigen::Index>(2 * k)) = reckoned_per_m * p;
      const double decay = tau > 0.0 ? std::exp(-1.0 / tau) : 1.0;
      const double fresh = slow * std::sqrt(1.0 - decay * decay);
      offset = decay * offset + Eigen::Vector2d(fresh * random.normal(), fresh * random.normal());
    }
    const auto fit = fit_heading(fixes, by_scale * by_scale.transpose());
    if (!fit) return -1.0;
    const double error = std::remainder(fit->yaw - 1.0, 2.0 * std::numbers::pi) / fit->sigma;
    sum += error * error / kRuns;
  }
  return sum;
}

TEST(HeadingFit, ItsSigmaIsThatOfItsErrors) {
  // χ² of 400 draws is within 1 ± 4 √(2/400) of its mean; the inflation by a poor fit makes the σ a little too large.
  EXPECT_NEAR(mean_square_of_errors(0.3, 0.0, 0.0, 0.0), 0.95, 0.3);
  EXPECT_NEAR(mean_square_of_errors(0.1, 0.8, 10.0, 0.0), 0.95, 0.3);
  EXPECT_NEAR(mean_square_of_errors(0.1, 0.0, 0.0, 0.1), 0.95, 0.3);
}

TEST(HeadingFit, PointsWithinTheNoiseLeaveTheHeadingOpen) {
  std::vector<ReckonedFix> fixes;
  for (const Eigen::Vector2d& p : curve(6)) fixes.push_back(fix(0.0, 0.001 * p, Eigen::Vector2d(1.0, 2.0), 1.0));
  const auto fit = fit_heading(fixes, no_error(fixes.size()));
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->sigma, std::numbers::pi / std::numbers::sqrt3, 0.02) << "uniform on the circle";
}

TEST(HeadingFit, AHeadingWithTwoSolutionsIsNone) {
  // Two fixes at one place, of a path out and back whose length only is uncertain.
  std::vector<ReckonedFix> fixes{fix(0.0, {0.0, 0.0}, {0.0, 0.0}, 0.01), fix(1.0, {0.0, 0.0}, {0.0, 0.0}, 0.01)};
  Eigen::MatrixXd reckoned = no_error(2);
  reckoned(2, 2) = 25.0;  // forwards, in the second point
  fixes[1].p_map = {4.0, 0.0};
  const auto fit = fit_heading(fixes, reckoned);
  ASSERT_TRUE(fit);
  EXPECT_GT(fit->sigma, 1.0) << "forwards to the east, or in reverse to the west";
}

TEST(HeadingFit, FixesThatDoNotFitThePathEnlargeTheSigma) {
  std::vector<ReckonedFix> fixes;
  const auto points = curve(8);
  for (const Eigen::Vector2d& p : points) fixes.push_back(fix(p.x(), p, p));
  const double before = fit_heading(fixes, no_error(fixes.size()))->sigma;
  fixes[4].p_map += Eigen::Vector2d(3.0, 0.0);
  EXPECT_GT(fit_heading(fixes, no_error(fixes.size()))->sigma, 5.0 * before);
}

TEST(HeadingFit, OnePointOrNumbersThatAreNoneGiveNothing) {
  EXPECT_FALSE(fit_heading({fix(0.0, {0.0, 0.0}, {0.0, 0.0})}, no_error(1)));
  const double nan = std::nan("");
  EXPECT_FALSE(fit_heading({fix(0.0, {0.0, 0.0}, {0.0, 0.0}), fix(1.0, {nan, 0.0}, {1.0, 0.0})}, no_error(2)));
}

}  // namespace
}  // namespace waymark::estimation
