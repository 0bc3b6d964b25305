// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "waymark/interface/payloads.hpp"
#include "waymark/interface/source.hpp"
#include "waymark/plugin_loader.hpp"

/// What the tests of the simulator share.
namespace waymark::test {

inline Rig rig_with(const Pose& T_base_lidar) {
  return Rig({{.name = "wheels", .payload = "", .T_base_sensor = {}},
              {.name = "gps", .payload = "", .T_base_sensor = {}},
              {.name = "lidar", .payload = "", .T_base_sensor = T_base_lidar}});
}

inline std::shared_ptr<Source> make_with(const Rig& rig, const std::string& yaml) {
  const PluginLoader loader({WAYMARK_PLUGIN_DIR});
  return loader.create<Source>("simulator", Config::parse(yaml), rig);
}

inline std::shared_ptr<Source> make(const std::string& yaml, const Pose& T_base_lidar = {}) {
  return make_with(rig_with(T_base_lidar), yaml);
}

inline std::vector<Measurement> read_all(Source& source) {
  std::vector<Measurement> all;
  while (auto measurement = source.next()) all.push_back(std::move(*measurement));
  return all;
}

inline const std::string kLoop =
    "{ duration_s: 60, seed: 3, course: { waypoints_m: [0, 0, 12, 0, 12, 8, 0, 8] },"
    "  landmarks: { count: 10, area_m: [-5, -5, 17, 13], seed: 7 }";
inline const std::string kWheels = ", wheels: { sensor: wheels, track_m: 0.5 }";
inline const std::string kGps = ", gps: { sensor: gps, correlated_sigma_m: 0.5 }";
inline const std::string kLidar = ", lidar: { sensor: lidar, beams: 90, step_deg: 3 }";

/// The robot drives one metre east and stands at x = 1 (to a millimetre) from about 3 s on.
inline const std::string kShortDrive = "{ course: { waypoints_m: [0, 0, 1, 0] }, lookahead_m: 2";

}  // namespace waymark::test
