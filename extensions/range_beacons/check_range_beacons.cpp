// SPDX-License-Identifier: Apache-2.0
// Checks of the map module range_beacons: the contract kit, and maps of a known path against truth. Prints what is
// wrong, and fails if anything is.
#include <cmath>
#include <cstdio>
#include <numbers>

#include "range_beacons.cpp"
#include "waymark/math/random.hpp"
#include "waymark/testing/map_module_contract.hpp"

namespace {

using namespace waymark;
using namespace waymark::range_beacons;

int failures = 0;

void expect(bool holds, const char* what) {
  if (holds) return;
  ++failures;
  std::fprintf(stderr, "failed: %s\n", what);
}

const Eigen::Vector2d kBeacons[] = {{12.0, 9.0}, {-8.0, 15.0}, {5.0, -14.0}};

/// A circle of 6 m, or a straight line.
Pose pose_at(int i, bool straight) {
  const double angle = 0.05 * i;
  if (straight) return Pose::planar(0.1 * i, 0.0, 0.0);
  return Pose::planar(6.0 * std::sin(angle), 6.0 - 6.0 * std::cos(angle), angle);
}

std::shared_ptr<Ranges> ranges_at(const Pose& pose, int i, double scale) {
  Random random({.seed = 1, .slot = 0, .stamp = i, .sensor = 0});
  auto out = std::make_shared<Ranges>();
  for (int b = 0; b < 3; ++b) {
    const double distance = (pose.p.head<2>() - kBeacons[b]).norm();
    out->ranges.push_back({b, scale * distance + 0.05 * random.normal(), -1, std::nan("")});
  }
  return out;
}

Measurement measurement_of(std::shared_ptr<Ranges> ranges, int i) {
  Measurement m;
  m.stamp = m.arrival = Time(std::chrono::milliseconds(200 * i));
  m.sequence = static_cast<std::uint64_t>(i);
  m.payload = std::move(ranges);
  return m;
}

RangeBeacons make_module() {
  const Config config =
      Config::parse("{ inputs: [radio], base_p_antenna_m: [0.2, 0.0, 0.5], sigma_m: 0.1, scale_sigma: 0.1 }");
  return {config, Rig({{"radio", "waymark/Ranges@1", Pose{}}})};
}

void check_contract() {
  RangeBeacons module = make_module();
  std::vector<testing::MappingStep> steps(40);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const int k = static_cast<int>(i);
    steps[i].T_map_base = pose_at(3 * k, false);
    steps[i].trigger = measurement_of(ranges_at(steps[i].T_map_base, k, 1.05), k);
  }
  const testing::Violations found = testing::check_map_module(module, steps);
  std::fputs(testing::to_text(found).c_str(), stderr);
  failures += static_cast<int>(found.size());
}

/// The map of a path that is known, after so many steps.
BeaconMap map_of(bool straight, double scale, int steps) {
  Settings settings;
  settings.sigma_m = 0.05;
  settings.scale_sigma = 0.1;
  settings.outlier_share = 0.01;
  settings.range_max_m = 100.0;
  settings.settled = 0.2;
  BeaconMap map(settings);
  for (int i = 0; i < steps; ++i) {
    const Pose pose = pose_at(i, straight);
    RangeSet set;
    const auto burst = ranges_at(pose, i, scale);
    for (const Ranges::One& one : burst->ranges) set.ranges.push_back({one.beacon, one.range_m, 0.05});
    map.insert({pose, Eigen::Matrix3d::Zero()}, set, nullptr);
  }
  return map;
}

void check_circle() {
  for (const double scale : {0.93, 1.0, 1.07}) {
    MapDescription found;
    map_of(false, scale, 200).describe(found);
    expect(found.landmarks.size() == 3, "a circle finds every beacon");
    for (const LandmarkView& one : found.landmarks) {
      const Eigen::Vector2d error = one.p_map - kBeacons[one.id];
      const double allowed = 0.02 + 4.0 * std::sqrt(one.P.topLeftCorner<2, 2>().trace());
      expect(error.norm() < allowed && error.norm() < 0.3, "a beacon stands where it is found");
    }
    for (const MapFigure& figure : found.figures) {
      if (figure.name == "scale") expect(std::abs(figure.value - scale) < 0.01, "the scale is found");
    }
  }
}

void check_line() {
  MapDescription found;
  map_of(true, 1.0, 100).describe(found);
  expect(found.landmarks.empty(), "from a straight line every beacon has two places, so none is found");
}

void check_refusal() {
  auto ranges = std::make_shared<Ranges>();
  ranges->ranges.push_back({1, 2.0, 0, std::nan("")});
  bool refused = false;
  try {
    make_module().extract(measurement_of(std::move(ranges), 0), {}, {});
  } catch (const DataError&) {
    refused = true;
  }
  expect(refused, "differences of ranges are refused");
}

}  // namespace

int main() {
  check_contract();
  check_circle();
  check_line();
  check_refusal();
  return failures == 0 ? 0 : 1;
}
