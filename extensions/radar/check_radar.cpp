// SPDX-License-Identifier: Apache-2.0
// Runs the contract kit on the sensor, with and without its states, in the plane and in space.
#include <cstdio>

#include "checks.hpp"
#include "drawn_scan.hpp"
#include "radar.cpp"
#include "waymark/testing/sensor_contract.hpp"

using namespace waymark;

namespace {

std::vector<Measurement> scans(double elevation_max_rad) {
  std::vector<Measurement> measurements(12);
  for (std::size_t i = 0; i < measurements.size(); ++i) {
    const radar::DrawnScan scan{.v = {3.0 + 0.1 * static_cast<double>(i), 0.5, 0.0},
                                .still = i == 5 ? std::size_t{3} : std::size_t{40},  // one too few
                                .moving = 5,
                                .v_moving = {8.0, 0.0, 0.0},
                                .elevation_max_rad = elevation_max_rad,
                                .noise_mps = 0.03};
    auto payload = std::make_shared<RadarTargets>();
    payload->targets = radar::draw(scan, Random({1, 0, static_cast<std::int64_t>(i), 0}));
    measurements[i].stamp = measurements[i].arrival = Time(std::chrono::milliseconds(75 * i));
    measurements[i].sequence = i;
    measurements[i].payload = std::move(payload);
  }
  return measurements;
}

int check(const char* keys, StateLayout::Motion motion, double elevation_max_rad) {
  const Rig rig({{"front", "", Pose{so3::from_rpy(0.05, -0.03, 0.4), {3.5, 0.7, 0.4}}}});
  const Config config = Config::parse(keys);
  const radar::Radar sensor(config, rig);
  config.reject_unread();
  const testing::Violations found = testing::check_sensor(sensor, scans(elevation_max_rad), motion);
  if (!found.empty()) std::fprintf(stderr, "%s:\n%s", keys, testing::to_text(found).c_str());
  return found.empty() ? 0 : 1;
}

/// What the sensor makes of single scans.
int check_behaviour() {
  radar::Checks checks;
  const Rig rig({{"front", "", Pose::planar(3.5, 0.7, 0.4)}});
  radar::Radar sensor(Config::parse("{ name: front, rear_axle: {} }"), rig);
  const StateLayout layout(StateLayout::Motion::planar, {});
  Belief belief;
  belief.P = ErrorMatrix::Identity(layout.size(), layout.size());
  const Prediction prediction{belief, layout, nullptr, nullptr, false};
  const std::vector<Measurement> measurements = scans(0.0);
  UpdateList updates;

  sensor.process(measurements[4], prediction, updates);
  checks.expect(updates.size() == 2, "a velocity and the rear axle");
  checks.expect(updates.motion() == UpdateList::Motion::moving, "the robot moves");
  checks.expect(updates.degraded_reason().empty(), "nothing is degraded");
  // The radar's velocity, turned into the base; the axle determines how much of it is rotation.
  const Eigen::Vector3d v = so3::from_rpy(0.0, 0.0, 0.4) * Eigen::Vector3d(3.4, 0.5, 0.0);
  const auto seen = sensor.observed_motion(measurements[4], nullptr);
  checks.expect(seen.has_value(), "a scan states the motion");
  checks.near(seen ? seen->yaw_rate_radps : 0.0, v.y() / 3.5, 0.03, "yaw rate by one scan");
  checks.near(seen ? seen->speed_mps : 0.0, v.x() + v.y() / 3.5 * 0.7, 0.05, "speed by one scan");

  updates.clear();
  sensor.process(measurements[5], prediction, updates);
  checks.expect(updates.size() == 0 && !updates.degraded_reason().empty(), "too few targets degrade the sensor");
  checks.expect(!sensor.observed_motion(measurements[5], nullptr), "and state nothing");
  return checks.result();
}

}  // namespace

int main() {
  using Motion = StateLayout::Motion;
  return check_behaviour() + check("{ name: front }", Motion::planar, 0.0) +
         check(
             "{ name: front, mounting_yaw_sigma_deg: 0.2, speed_scale_sigma: 0.001, rear_axle: { slip_rad_s2_per_m: "
             "0.005, slip_sigma_rad_s2_per_m: 0.002 } }",
             Motion::planar, 0.0) +
         check("{ name: front, dimensions: 3, mounting_yaw_sigma_deg: 0.2, rear_axle: { slip_rad_s2_per_m: 0.005 } }",
               Motion::spatial, 0.4);
}
