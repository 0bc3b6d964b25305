// SPDX-License-Identifier: Apache-2.0
// Checks the velocity from one scan on drawn targets.
#include <Eigen/LU>
#include <algorithm>

#include "checks.hpp"
#include "drawn_scan.hpp"
#include "ego_velocity.hpp"

using namespace waymark;
using namespace waymark::radar;

namespace {

ScanSettings settings(int dimensions) {
  ScanSettings s;
  s.dimensions = dimensions;
  s.doppler_sigma_mps = 0.05;
  s.gate_sigma = 3.0;
  s.draws = 100;
  s.min_inliers = 8;
  s.min_share = 0.3;
  return s;
}

Random random_of(std::int64_t stamp) { return Random({1, 0, stamp, 0}); }

void finds_the_velocity(Checks& checks) {
  const DrawnScan scan{.v = {12.0, -3.0, 0.0}};
  EgoVelocityEstimator estimator(settings(2));
  const EgoVelocity found = estimator.estimate(draw(scan, random_of(1)), random_of(2));
  checks.near((found.v - scan.v).norm(), 0.0, 1e-3, "without noise the velocity is exact");
  checks.expect(found.inliers == 100 && estimator.believed(found), "all targets stand still");
}

void finds_three_components(Checks& checks) {
  const DrawnScan scan{.v = {1.0, -0.5, 0.7}, .elevation_max_rad = 0.5};
  EgoVelocityEstimator estimator(settings(3));
  const EgoVelocity found = estimator.estimate(draw(scan, random_of(1)), random_of(2));
  checks.near((found.v - scan.v).norm(), 0.0, 1e-3, "three components without noise");
}

/// A truck beside the car: more than half of the targets move, all with one velocity.
void leaves_moving_targets_out(Checks& checks) {
  std::size_t wrong = 0;
  for (std::int64_t k = 0; k < 200; ++k) {
    const DrawnScan scan{
        .v = {15.0, 0.5, 0.0}, .still = 60, .moving = 55, .v_moving = {20.0, 1.0, 0.0}, .noise_mps = 0.05};
    EgoVelocityEstimator estimator(settings(2));
    const EgoVelocity found = estimator.estimate(draw(scan, random_of(k)), random_of(-k - 1));
    if ((found.v - scan.v).norm() > 0.3) ++wrong;
    const auto flags = estimator.stands_still();
    const auto taken = std::count(flags.begin() + 60, flags.end(), 1);
    checks.expect(taken <= 5, "moving targets are outliers");
  }
  checks.expect(wrong == 0, "traffic does not pull the velocity: " + std::to_string(wrong) + " of 200 scans");
}

/// The mean of χ² over many scans is the number of components.
void has_the_right_covariance(Checks& checks) {
  double nees = 0.0;
  const int scans = 400;
  for (std::int64_t k = 0; k < scans; ++k) {
    const DrawnScan scan{.v = {5.0, 1.0, 0.0}, .still = 40, .noise_mps = 0.05};
    EgoVelocityEstimator estimator(settings(2));
    const EgoVelocity found = estimator.estimate(draw(scan, random_of(k)), random_of(-k - 1));
    const Eigen::Vector2d error = (found.v - scan.v).head<2>();
    nees += error.dot(found.white.topLeftCorner<2, 2>().inverse() * error) / scans;
  }
  checks.expect(nees > 1.6 && nees < 2.4, "NEES of two components: " + std::to_string(nees));
}

void refuses_too_few(Checks& checks) {
  EgoVelocityEstimator estimator(settings(2));
  const DrawnScan few{.v = {5.0, 0.0, 0.0}, .still = 6};
  checks.expect(!estimator.believed(estimator.estimate(draw(few, random_of(1)), random_of(2))),
                "six targets are too few");
  checks.expect(!estimator.believed(estimator.estimate({}, random_of(2))), "no target is too few");
  DrawnScan chaos{.v = {5.0, 0.0, 0.0}, .still = 10};
  auto targets = draw(chaos, random_of(1));
  Random random = random_of(3);
  for (int i = 0; i < 90; ++i) {
    targets.push_back({.range_m = 10.0, .azimuth_rad = random.uniform(), .radial_mps = 60.0 * random.uniform()});
  }
  checks.expect(!estimator.believed(estimator.estimate(targets, random_of(2))),
                "ten of a hundred are too small a share");
}

void same_key_same_velocity(Checks& checks) {
  const auto targets = draw({.v = {9.0, 1.0, 0.0}, .still = 50, .moving = 40, .noise_mps = 0.1}, random_of(1));
  EgoVelocityEstimator one(settings(2));
  EgoVelocityEstimator other(settings(2));
  other.estimate(draw({.still = 300}, random_of(5)), random_of(6));
  checks.expect(one.estimate(targets, random_of(2)).v == other.estimate(targets, random_of(2)).v,
                "the velocity depends on the scan and the key only");
}

}  // namespace

int main() {
  Checks checks;
  finds_the_velocity(checks);
  finds_three_components(checks);
  leaves_moving_targets_out(checks);
  has_the_right_covariance(checks);
  refuses_too_few(checks);
  same_key_same_velocity(checks);
  return checks.result();
}
