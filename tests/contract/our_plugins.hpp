// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "waymark/interface/payloads.hpp"
#include "waymark/interface/source.hpp"
#include "waymark/plugin_loader.hpp"
#include "waymark/testing/map_module_contract.hpp"

/// Plugins of this repository and data for them, as the contract tests use them.
namespace waymark::contract_test {

inline Rig rig() {
  return Rig({{"wheels", "", {}},
              {"gps", "", {}},
              {"lidar", "", Pose{so3::from_rpy(0.0, 0.0, 0.1), {0.3, 0.05, 0.0}}},
              {"imu", "", Pose{so3::from_rpy(0.2, -0.1, 1.5), {0.1, 0.0, 0.3}}},
              {"compass", "", Pose{so3::from_rpy(0.05, 0.1, -0.7), {0.0, 0.0, 0.4}}},
              {"altimeter", "", Pose{so3::from_rpy(0.0, 0.0, 0.3), {0.2, -0.1, -0.1}}}});
}

template <class Interface>
std::shared_ptr<Interface> make(std::string_view plugin, const std::string& yaml) {
  return PluginLoader({WAYMARK_PLUGIN_DIR}).create<Interface>(plugin, Config::parse(yaml), rig());
}

/// Measurements a tenth of a second apart, with a gap, whose payloads `fill(payload, t)` sets.
template <class P, class Fill>
std::vector<Measurement> stream_of(int count, const Fill& fill) {
  std::vector<Measurement> measurements;
  for (int k = 0; k < count; ++k) {
    const double t = 0.1 * k + (k > count / 2 ? 0.33 : 0.0);
    auto payload = std::make_shared<P>();
    fill(*payload, t);
    Measurement m;
    m.stamp = m.arrival = Time{from_seconds(100.0 + t)};
    m.sequence = static_cast<std::uint64_t>(k);
    m.payload = std::move(payload);
    measurements.push_back(std::move(m));
  }
  return measurements;
}

inline std::vector<Measurement> wheel_speeds(int count) {
  return stream_of<WheelSpeeds>(count, [](WheelSpeeds& w, double t) {
    w.left_mps = 1.0 + 0.5 * std::sin(t);
    w.right_mps = 1.0 + 0.5 * std::cos(2.0 * t);
  });
}

inline const std::string kSimulation =
    "{ duration_s: 40, seed: 3, course: { waypoints_m: [0, 0, 12, 0, 12, 8, 0, 8] },"
    "  landmarks: { count: 14, area_m: [-5, -5, 17, 13], seed: 7 },"
    "  wheels: { sensor: wheels, track_m: 0.5 }, gps: { sensor: gps, correlated_sigma_m: 0.5, outages_s: [5, 8] },"
    "  lidar: { sensor: lidar, range_max_m: 20, rate_hz: 2, delay_s: 0.07 } }";

inline Pose true_pose(const Reference& reference, Time stamp) {
  const Reference::Point* nearest = &reference.trajectory.front();
  for (const Reference::Point& point : reference.trajectory) {
    if (std::abs((point.stamp - stamp).count()) < std::abs((nearest->stamp - stamp).count())) nearest = &point;
  }
  return nearest->T_map_base;
}

/// Simulated scans with where the robot was; every third beam glints.
inline std::vector<testing::MappingStep> mapping_steps(std::size_t most) {
  const auto source = make<Source>("simulator", kSimulation);
  const auto reference = source->reference();
  std::vector<testing::MappingStep> steps;
  while (auto m = source->next()) {
    if (steps.size() == most) break;
    if (m->payload->type() != LaserScan::kType) continue;
    auto scan = std::make_shared<LaserScan>(m->as<LaserScan>());
    for (std::size_t i = 0; i < scan->ranges_m.size(); ++i) scan->intensities.push_back(i % 30 < 10 ? 5.0f : 0.0f);
    m->payload = std::move(scan);
    steps.push_back({.trigger = *m, .T_map_base = true_pose(*reference, m->stamp)});
  }
  return steps;
}

inline std::string feature_map_yaml(const std::string& attributes) {
  return "{ inputs: [lidar], attributes: [" + attributes +
         "], extraction: { range_min_m: 0.2, range_max_m: 19, no_return_m: 20.5, bright_above: 1 },"
         "  existence: { view_range_m: 19, view_half_angle_deg: 130 } }";
}

}  // namespace waymark::contract_test
