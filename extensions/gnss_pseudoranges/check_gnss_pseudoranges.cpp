// SPDX-License-Identifier: Apache-2.0
// Checks of the sensor gnss_pseudoranges: the contract kit in the plane and in space, the noise of reflections against
// its posterior by summation, and the first fix. Prints what is wrong, and fails if anything is.
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>

#include "gnss_pseudoranges.cpp"
#include "waymark/testing.hpp"

namespace {

using namespace waymark;
using namespace waymark::gnss;

int failures = 0;

void expect(bool holds, const char* what) {
  if (holds) return;
  ++failures;
  std::fprintf(stderr, "failed: %s\n", what);
}

void expect_near(double value, double right, double tolerance, const char* what) {
  if (std::abs(value - right) <= tolerance) return;
  ++failures;
  std::fprintf(stderr, "failed: %s: %g, expected %g within %g\n", what, value, right, tolerance);
}

const Datum kDatum{52.5, 13.4, 80.0};
constexpr const char* kPlanar =
    "{ name: gnss, base_p_antenna_m: [0.3, 0.1, 1.5], systems: [1, 4], height_sigma_m: 5, clock_sigma_m: 100 }";
constexpr const char* kSpatial = "{ name: gnss, base_p_antenna_m: none, systems: [4, 1], clock_sigma_m: 100 }";

/// Ten satellites around the receiver's sky, the odd ones of system 4, which is 7 m late.
Pseudoranges epoch_at(const Eigen::Vector3d& p_enu, double clock, double late = 0.0) {
  const LocalAxes axes(kDatum);
  const Eigen::Vector3d origin = to_ecef(kDatum);
  Eigen::Matrix3d R_ecef_enu;
  for (int i = 0; i < 3; ++i) R_ecef_enu.row(i) = axes.to_enu(origin + Eigen::Vector3d::Unit(i)).transpose();
  Pseudoranges epoch;
  for (int k = 0; k < 10; ++k) {
    const double azimuth = 2.0 * std::numbers::pi * k * 0.381966;
    const double elevation = 0.2 + 0.12 * k;
    const Eigen::Vector3d s = 2.2e7 * Eigen::Vector3d(std::sin(azimuth) * std::cos(elevation),
                                                      std::cos(azimuth) * std::cos(elevation), std::sin(elevation));
    Pseudoranges::One one;
    one.number = k;
    one.system = k % 2 == 0 ? 1 : 4;
    one.p_ecef_m = origin + R_ecef_enu * s;
    one.range_m = (axes.satellite(one.p_ecef_m) - p_enu).norm() + clock + (one.system == 4 ? 7.0 : 0.0);
    one.cn0_dbhz = 50.0 - k % 3;
    if (k == 4) one.range_m += late;
    epoch.satellites.push_back(one);
  }
  return epoch;
}

testing::Violations contract(const char* yaml, StateLayout::Motion motion) {
  const auto epochs = testing::measurements_of<Pseudoranges>(20, 0.2, [](Pseudoranges& epoch, double t) {
    epoch = epoch_at({t, 2.0, 1.5}, 30.0 + t, t > 2.0 ? 60.0 : 0.0);
  });
  testing::SensorSetting setting;
  setting.datum = kDatum;
  return testing::check_sensor(GnssPseudoranges(Config::parse(yaml)), epochs, motion, setting);
}

/// Mean and variance of d under N(d; 0, prior) times the density of the noise at nu − d, by summation.
std::pair<double, double> true_posterior(const LateSignal& noise, double nu, double prior) {
  const double s = std::sqrt(noise.variance);
  const double tau = noise.mean_excess;
  double sum = 0.0, first = 0.0, second = 0.0;
  for (int i = -20000; i <= 20000; ++i) {
    const double d = 8.0 * std::sqrt(prior) * i / 20000.0;
    const double e = nu - d;
    const double direct = std::exp(-0.5 * e * e / noise.variance) / (s * std::sqrt(2.0 * std::numbers::pi));
    const double late = std::exp(noise.variance / (2.0 * tau * tau) - e / tau) * 0.5 *
                        std::erfc(-(e / s - s / tau) / std::numbers::sqrt2) / tau;
    const double weight = std::exp(-0.5 * d * d / prior) * ((1.0 - noise.share) * direct + noise.share * late);
    sum += weight;
    first += weight * d;
    second += weight * d * d;
  }
  return {first / sum, second / sum - first * first / (sum * sum)};
}

void check_noise() {
  const LateSignal noise{16.0, 0.4, 40.0};
  for (const double prior : {4.0, 100.0}) {
    for (const double nu : {-20.0, -5.0, 0.0, 3.0, 10.0, 25.0, 60.0, 150.0}) {
      const Moments gaussian = equivalent_noise(noise, nu, prior);
      const double S = prior + gaussian.variance;
      const auto [mean, variance] = true_posterior(noise, nu, prior);
      expect_near(prior / S * (nu - gaussian.mean), mean, 1e-2, "mean of the posterior with reflections");
      const bool is_limited = (nu - gaussian.mean) * (nu - gaussian.mean) / S > 3.99;
      if (!is_limited) expect_near(prior - prior * prior / S, variance, 1e-2 * prior, "its variance");
      expect(gaussian.variance >= noise.variance - 1e-9, "no signal is better than a direct one");
    }
  }
  const Moments wide = equivalent_noise(noise, -1e5, 1e10);
  expect_near(wide.mean, 0.4 * 40.0, 1e-9, "a wide prior leaves the mean of the noise");
}

void check_first_fix() {
  const Receiver receiver(Config::parse("{ systems: [1, 4] }"));
  const Eigen::Vector3d p(120.0, -45.0, 3.0);
  const LocalAxes axes(kDatum);
  const auto mean_delay = receiver.noise(epoch_at(p, 0.0).satellites[0]).moments().mean;
  const auto found = first_fix(epoch_at(p, -1.4e5), receiver);
  expect(found.has_value(), "ten satellites give a position");
  if (found)
    expect_near((axes.to_enu(found->p_ecef) - p).norm(), 0.0, 3.0 + mean_delay, "the position of ten satellites");
  const auto reflected = first_fix(epoch_at(p, -1.4e5, 200.0), receiver);
  expect(reflected.has_value(), "with a reflection, too");
  if (reflected) expect_near((axes.to_enu(reflected->p_ecef) - p).norm(), 0.0, 12.0, "which counts for little");
  auto few = epoch_at(p, 0.0);
  few.satellites.resize(5);
  expect(!first_fix(few, receiver), "five satellites of two systems give no position that can be checked");
  const Datum datum = to_datum(to_ecef(kDatum));
  expect_near(datum.latitude_deg, kDatum.latitude_deg, 1e-10, "latitude, there and back");
  expect_near(datum.height_m, kDatum.height_m, 1e-5, "height, there and back");
}

}  // namespace

int main() {
  check_noise();
  check_first_fix();
  return failures + testing::report({contract(kPlanar, StateLayout::Motion::planar),
                                     contract(kSpatial, StateLayout::Motion::spatial),
                                     testing::check_keys<GnssPseudoranges>(kPlanar)});
}
