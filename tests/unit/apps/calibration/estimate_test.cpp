// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/calibration/estimate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace waymark::calibration {
namespace {

constexpr std::size_t kCount = 4000;

Parameter parameter(const char* key, double step, double prior_sigma, Parameter::Kind kind = Parameter::Kind::value) {
  Parameter one;
  one.sensor = "sensor";
  one.key = key;
  one.kind = kind;
  one.step = step;
  one.prior_sigma = prior_sigma;
  return one;
}

/// Innovations of a scalar: ν = a (truth − θ) x + noise of `sigma`, which the filter believes to be `believed`.
Run scalar_run(double error, double sigma, double believed, unsigned seed = 1, double memory = 0.0) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Run run;
  double noise = 0.0;
  for (std::size_t i = 0; i < kCount; ++i) {
    noise = memory * noise + std::sqrt(1.0 - memory * memory) * sigma * normal(random);
    Innovation one;
    one.measurement = i;
    one.nu.resize(1);
    one.S.resize(1, 1);
    one.nu(0) = error * std::sin(0.01 * static_cast<double>(i)) + noise;
    one.S(0, 0) = believed * believed;
    run.innovations.push_back(one);
  }
  return run;
}

Estimate estimate_of(const std::vector<Parameter>& parameters, const Rerun& rerun) {
  return estimate(parameters, rerun, 1, [](const Estimate&) {});
}

TEST(CalibrationEstimate, FindsAValueWithinItsSigma) {
  int within = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const auto rerun = [&](const Eigen::VectorXd& change) { return scalar_run(0.3 - change(0), 0.5, 0.5, seed); };
    const Estimate found = estimate_of({parameter("offset", 0.01, 1.0)}, rerun);
    EXPECT_TRUE(found.converged);
    // Fisher: σ = 0.5 / √(Σ sin²) = 0.5 / √2000.
    EXPECT_NEAR(found.sigma(0), 0.5 / std::sqrt(2000.0), 0.6 * 0.5 / std::sqrt(2000.0));
    within += std::abs(found.change(0) - 0.3) < 2.0 * found.sigma(0) ? 1 : 0;
  }
  EXPECT_GE(within, 17) << "95 % of 20; fewer than 17 have a probability of 0.3 %";
}

TEST(CalibrationEstimate, FindsTheLevelOfTheNoise) {
  const auto rerun = [](const Eigen::VectorXd& change) { return scalar_run(0.0, 0.8, 0.5 * std::exp(change(0))); };
  const Estimate found = estimate_of({parameter("sigma", 0.05, 1.0, Parameter::Kind::noise)}, rerun);
  EXPECT_TRUE(found.converged);
  EXPECT_NEAR(0.5 * std::exp(found.change(0)), 0.8, 0.03);
  EXPECT_NEAR(found.nis_after, 1.0, 0.05);
  EXPECT_GT(found.nis_before, 2.0);
}

TEST(CalibrationEstimate, WhatTheLogDoesNotShowKeepsItsPrior) {
  const auto rerun = [](const Eigen::VectorXd&) { return scalar_run(0.0, 0.5, 0.5); };
  const Estimate found = estimate_of({parameter("unseen", 0.01, 0.2)}, rerun);
  EXPECT_NEAR(found.change(0), 0.0, 1e-9);
  EXPECT_NEAR(found.sigma(0), 0.2, 1e-9);
  EXPECT_NEAR(found.information(0), 0.0, 1e-9);
}

TEST(CalibrationEstimate, CorrelatedNoiseDoesNotMakeItSurer) {
  const auto rerun = [](const Eigen::VectorXd& change) { return scalar_run(0.3 - change(0), 0.5, 0.5, 3, 0.98); };
  const Estimate found = estimate_of({parameter("offset", 0.01, 1.0)}, rerun);
  EXPECT_GT(found.sigma(0), 2.0 * 0.5 / std::sqrt(2000.0)) << "of independent noise";
}

TEST(CalibrationEstimate, GeometryDoesNotChangeToMendAWrongNoise) {
  // The filter believes in more noise than there is, and the parameter also scales that.
  const auto rerun = [](const Eigen::VectorXd& change) {
    return scalar_run(0.3 - change(0), 0.5, 2.0 * std::exp(change(0)));
  };
  const Estimate found = estimate_of({parameter("offset", 0.01, 1.0)}, rerun);
  EXPECT_TRUE(found.converged);
  EXPECT_NEAR(found.change(0), 0.3, 0.05);
}

TEST(CalibrationEstimate, AnOutlierHardlyMovesIt) {
  const auto rerun = [](const Eigen::VectorXd& change) {
    calibration::Run result = scalar_run(0.3 - change(0), 0.5, 0.5);
    for (std::size_t i = 100; i < 120; ++i) result.innovations[i].nu(0) += 50.0;
    return result;
  };
  const Estimate found = estimate_of({parameter("offset", 0.01, 1.0)}, rerun);
  EXPECT_NEAR(found.change(0), 0.3, 0.05);
}

}  // namespace
}  // namespace waymark::calibration
