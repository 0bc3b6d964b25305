// SPDX-License-Identifier: Apache-2.0
// Checks of the sensor indoor_gps: the contract kit on a planar and a spatial robot, and its parts against truth.
// Prints what is wrong, and fails if anything is.
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include "indoor_gps.cpp"
#include "waymark/testing/sensor_contract.hpp"

namespace {

using namespace waymark;
using namespace waymark::indoor_gps;

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

constexpr const char* kPlanar =
    "{ name: radio, base_p_antenna_m: [0.3, 0.1, 0.5], sigma_m: 0.1, use_reported_sigma: true, late_share: 0.1, "
    "scale_sigma: 0.05, offset_sigma_m: 0.2, offset_of: per_beacon, beacons: ["
    "{ number: 3, map_p_beacon_m: [40, -20] }, { number: 4, map_p_beacon_m: [-30, -25] }, "
    "{ number: 9, map_p_beacon_m: [0, 45] }] }";
constexpr const char* kSpatial =
    "{ name: radio, base_p_antenna_m: [0.3, 0.1, 0.5], sigma_m: 0.1, scale_sigma: 0.05, beacons: ["
    "{ number: 3, map_p_beacon_m: [40, -20, 3] }, { number: 4, map_p_beacon_m: [-30, -25, 1] }, "
    "{ number: 9, map_p_beacon_m: [0, 45, 6] }] }";

/// Bursts of one range, of several, and of differences.
std::vector<Measurement> bursts() {
  std::vector<Measurement> measurements(30);
  for (std::size_t i = 0; i < measurements.size(); ++i) {
    auto ranges = std::make_shared<Ranges>();
    const double longer = 0.3 * std::sin(static_cast<double>(i));
    ranges->ranges.push_back({3, 44.7 + longer, -1, std::nan("")});
    if (i % 3 > 0) ranges->ranges.push_back({4, 39.1 - longer, i % 3 == 2 ? 3 : -1, 0.2});
    if (i % 3 > 0) ranges->ranges.push_back({9, 45.0, i % 3 == 2 ? 3 : -1, 0.2});
    if (i % 5 == 1) {
      for (int k = 0; k < 20; ++k) ranges->ranges.push_back({9, 45.0 + 0.1 * k, -1, 0.2});
    }
    measurements[i].stamp = measurements[i].arrival = Time(std::chrono::milliseconds(100 * i));
    measurements[i].sequence = i;
    measurements[i].payload = std::move(ranges);
  }
  return measurements;
}

void check_contract(const char* yaml, StateLayout::Motion motion) {
  const IndoorGps sensor(Config::parse(yaml));
  const testing::Violations found = testing::check_sensor(sensor, bursts(), motion);
  std::fputs(testing::to_text(found).c_str(), stderr);
  failures += static_cast<int>(found.size());
}

/// Mean and variance of d under N(d; 0, prior) times the density of nu − d, by summation.
std::pair<double, double> true_posterior(double nu, double prior, double variance, double share, double tau,
                                         bool both) {
  double sum = 0.0;
  double first = 0.0;
  double second = 0.0;
  const double s = std::sqrt(variance);
  const auto late = [&](double e) {
    return std::exp(variance / (2.0 * tau * tau) - e / tau) * 0.5 *
           std::erfc(-(e / s - s / tau) / std::numbers::sqrt2) / tau;
  };
  const double width = 8.0 * std::sqrt(prior);
  for (int i = -20000; i <= 20000; ++i) {
    const double d = width * i / 20000.0;
    const double e = nu - d;
    const double direct = std::exp(-0.5 * e * e / variance) / (s * std::sqrt(2.0 * std::numbers::pi));
    double likelihood = (1.0 - (both ? 2.0 : 1.0) * share) * direct + share * late(e);
    if (both) likelihood += share * late(-e);
    const double weight = std::exp(-0.5 * d * d / prior) * likelihood;
    sum += weight;
    first += weight * d;
    second += weight * d * d;
  }
  const double mean = first / sum;
  return {mean, second / sum - mean * mean};
}

void check_late_paths() {
  const double prior = 0.04;
  const double variance = 0.01;
  for (const bool both : {false, true}) {
    const LatePaths late(0.1, 0.8);
    for (const double nu : {-0.6, -0.2, 0.0, 0.2, 0.5, 0.9, 1.5, 4.0}) {
      const EquivalentInnovation seen = late.equivalent(nu, prior + variance, both);
      const auto [mean, spread] = true_posterior(nu, prior, variance, 0.1, 0.8, both);
      expect_near(prior / seen.variance * seen.nu, mean, 1e-3, "mean of the posterior with late paths");
      const double updated = prior - prior * prior / seen.variance;
      const bool is_limited = seen.nu * seen.nu / seen.variance > 3.999;
      if (!is_limited) expect_near(updated, spread, 1e-3, "variance of the posterior with late paths");
      expect(updated > 0.0 && updated < prior, "an update makes the prior narrower");
    }
  }
  const EquivalentInnovation far = LatePaths(0.1, 0.8).equivalent(500.0, 0.05, false);
  expect(std::isfinite(far.nu) && far.nu * far.nu / far.variance < 4.001,
         "a range that is far too long is a late path");
  const EquivalentInnovation near = LatePaths(0.1, 0.8).equivalent(-5.0, 0.05, false);
  expect(near.nu * near.nu / near.variance > 100.0, "a range that is far too short is none");
}

std::vector<RangeRow> ranges_from(const Beacons& beacons, const Eigen::Vector3d& p, double scale) {
  std::vector<RangeRow> out;
  out.reserve(beacons.all().size());
  for (std::size_t i = 0; i < beacons.all().size(); ++i) {
    const double range = scale * (p - beacons.all()[i].p_map).norm();
    out.push_back({static_cast<int>(i), -1, range, 0.1, 0.01});
  }
  return out;
}

void check_multilateration() {
  const Beacons beacons(
      Config::parse("{ scale_sigma: 0.1, beacons: [{ number: 1, map_p_beacon_m: [0, 0, 2] }, "
                    "{ number: 2, map_p_beacon_m: [30, 0, 2] }, { number: 5, map_p_beacon_m: [0, 20, 2] }, "
                    "{ number: 7, map_p_beacon_m: [28, 22, 2] }] }"));
  const Eigen::Vector3d p(9.0, 13.0, 0.5);
  const auto ranges = ranges_from(beacons, p, 1.0);
  const auto found = multilaterate(beacons, ranges, 0.5);
  expect(found.has_value(), "four ranges give a position");
  if (found) expect_near((found->p_map_antenna - p.head<2>()).norm(), 0.0, 1e-3, "position from four ranges");
  const auto longer = multilaterate(beacons, ranges_from(beacons, p, 1.07), 0.5);
  expect(longer && (longer->p_map_antenna - p.head<2>()).norm() < 2.0 * longer->sigma,
         "position from ranges that are 7 % long");
  expect(!multilaterate(beacons, std::span(ranges).first(2), 0.5), "two ranges give no position");
  auto contradicting = ranges;
  contradicting[0].value += 8.0;
  expect(!multilaterate(beacons, contradicting, 0.5), "ranges that contradict each other give no position");
  const Beacons in_line(
      Config::parse("{ beacons: [{ number: 1, map_p_beacon_m: [0, 0] }, { number: 2, map_p_beacon_m: "
                    "[10, 0] }, { number: 3, map_p_beacon_m: [20, 0] }] }"));
  expect(!multilaterate(in_line, ranges_from(in_line, {9.0, 8.0, 0.0}, 1.0), 0.0),
         "beacons in a line give two positions");
}

void check_bursts() {
  const auto beacons = std::make_shared<const Beacons>(Config::parse(kSpatial));
  for (const int size : {1, 4, 5, 9, 24}) {
    std::vector<SizedRange> burst(static_cast<std::size_t>(size), {{0, -1, 10.0, 0.1, 0.01}, 1.0});
    burst.back().nis = 50.0;
    UpdateList updates;
    const int left_out = emplace_updates(burst, beacons, Eigen::Vector3d::Zero(), updates);
    int rows = 0;
    NavState state;
    const std::array<double, 1> block{1.0};
    Linearization out;
    for (std::size_t i = 0; i < updates.size(); ++i) {
      updates[i].linearize({state, block.data()}, out);
      rows += out.rows();
    }
    expect(rows + left_out == size, "every range of a burst is in an update, or left out");
    expect(left_out == (size == 24 ? 1 : 0), "a range that does not fit has an update of its own, if there is one");
  }
}

void expect_refused(const char* yaml, const char* part) {
  try {
    const IndoorGps sensor(Config::parse(yaml));
    expect(false, part);
  } catch (const ConfigError& error) {
    if (std::string(error.what()).find(part) == std::string::npos) {
      ++failures;
      std::fprintf(stderr, "failed: \"%s\" does not contain \"%s\"\n", error.what(), part);
    }
  }
}

void check_refusals() {
  expect_refused("{ base_p_antenna_m: none, sigma_m: 0.1, beacons: [] }", "at least one beacon");
  expect_refused("{ base_p_antenna_m: none, sigma_m: 0.1, beacons: [{ number: 1, map_p_beacon_m: [1] }] }",
                 "[x, y] or [x, y, z]");
  expect_refused(
      "{ base_p_antenna_m: none, sigma_m: 0.1, beacons: [{ number: 1, map_p_beacon_m: [1, 2] }, "
      "{ number: 1, map_p_beacon_m: [3, 4] }] }",
      "two beacons have the number 1");
}

}  // namespace

int main() {
  check_contract(kPlanar, StateLayout::Motion::planar);
  check_contract(kSpatial, StateLayout::Motion::spatial);
  check_late_paths();
  check_multilateration();
  check_bursts();
  check_refusals();
  return failures == 0 ? 0 : 1;
}
