// SPDX-License-Identifier: Apache-2.0
// Tables of every payload that the csv source reads, plain and gzip, and its references.
#include <array>

#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/input.hpp"
#include "tests/fuzz/source.hpp"

extern "C" const waymark::PluginDescriptor waymark_plugin_csv;

namespace waymark::fuzz::csv_harness {
namespace {
constexpr std::array kFiles{
    "payload: BodyTwist, time: 0, columns: { v_x_mps: 1, w_z_radps: 2 }",
    "payload: WheelSpeeds, time: 0, columns: { left_mps: 1, right_mps: 2 }, cumulative: { wraps_at: 65536 }",
    "payload: WheelSteering, time: t, columns: { speed_mps: v, steering_rad: { column: s, scale: 0.0174 } }",
    "payload: PoseIncrement, time: 0, columns: { x_m: 1, y_m: 2, yaw_rad: 3 }, cumulative: true",
    "payload: GnssFix, time: 0, arrival: 1, columns: { latitude_deg: 2, longitude_deg: 3, height_m: 4, satellites: 5, "
    "type: { column: 6, map: { 0: none, 1: single, 4: rtk_fixed } } }, empty_is_unknown: true, only_changes_of: [2, 3]",
    "payload: LaserScan, time: { column: 0, scale: 1e-9 }, columns: { ranges_m: { first: 1, last: 4 }, intensities: { "
    "first: 5, count: 4 } }, scan: { start_deg: -90, step_deg: 1, allow_non_finite: true }",
    "payload: ImuSample, time: 0, columns: { w_x_radps: 1, w_y_radps: 2, w_z_radps: 3, f_x_mps2: 4, f_y_mps2: 5, "
    "f_z_mps2: 6, q_w: 7, q_x: 8, q_y: 9, q_z: 10 }, min_step_s: 0.01",
    "payload: CompassHeading, time: { column: 0, offset_s: 0.5 }, columns: { heading_rad: 1 }, where: [{ column: 2, "
    "in: "
    "[1, 2] }, { column: 0, min: 0 }]",
    "payload: LandmarkObservations, time: 0, columns: { range_m: 1, bearing_rad: 2, identity: 3 }, group_by_time: true",
    "payload: Image, time: 0, columns: { file: 1 }",
    "payload: Height, time: 0, columns: { height_m: 1 }, delimiter: space, comment: \"%\", header_rows: 1",
    "payload: PoseIncrement, time: 0, columns: { left_m: 1, right_m: 2 }, cumulative: { wraps_at: 256 }, track_m: 0.4",
    "payload: MagneticField, time: 0, columns: { m_x_t: 1, m_y_t: 2, m_z_t: { column: 3, scale: 1e-6, offset: 1 } }",
    "payload: ImuSample, time: 0, end_of_interval: true, columns: { w_x_radps: { constant: 0 }, w_y_radps: { constant: "
    "0 }, w_z: { column: 1, unit: deg/s }, f_x_g: 2, f_y_g: 3, f_z_mg: 4 }",
    "payload: PoseIncrement, time_ms: 0, end_of_interval: true, columns: { x_mm: 1, y_mm: 2, yaw_deg: 3 }",
    "payload: PoseIncrement, time_ns: 0, cumulative: true, columns: { x_m: 1, y_m: 2, q_w: 3, q_x: 4, q_y: 5, q_z: 6 }",
    "payload: LaserScan, time: 0, group_by_time: true, end_of_interval: true, columns: { bearing_deg: 1, range_mm: 2, "
    "intensity: 3 }, scan: { start_deg: -180, step_deg: 0.5, beam_interval_s: 1e-4, allow_non_finite: true }",
    "payload: WheelSpeeds, time: 1, where: [{ column: 0, equals: ODO }, { column: 2, min: 0 }], columns: { left_kmh: "
    "2, "
    "right_kmh: 3 }",
    "payload: LaserScan, records: { skip_bytes: 3, fields: [f8, u1, 4 u2] }, time: 0, columns: { ranges_m: { first: 2, "
    "count: 4, scale: 0.001 } }, scan: { start_deg: -90, step_deg: 1 }",
    "payload: Ranges, time: 0, columns: { beacon: 1, range_m: 2, reference: 3 }, group_by_time: true",
    "payload: RadarTargets, time: 0, columns: { range_cm: 1, azimuth_deg: 2, radial_mps: 3 }, group_by_time: true",
};

void run(std::string_view input) {
  static const Rig kRig({{"a", "", Pose{}}, {"b", "", {}}});
  const Choice choice = choose(input, kFiles.size() + 3);
  write("log", choice.rest);
  std::string yaml = "max_bad_rows: 1000\n";
  if (choice.which < kFiles.size()) {
    yaml += "files:\n  - { path: log, sensor: a, " + std::string(kFiles[choice.which]) + " }\n";
  } else {
    write("good", "1,2\n2,3\n");
    yaml += "files:\n  - { path: good, sensor: a, payload: Height, time: 0, columns: { height_m: 1 } }\nreference:\n";
    yaml +=
        choice.which == kFiles.size()
            ? "  landmarks: { path: log, columns: { name: 0, x_m: 1, y_m: 2, radius_m: 3 } }\n"
        : choice.which == kFiles.size() + 1
            ? "  trajectory: { path: log, empty_is_unknown: true, columns: { time: 0, x_m: 1, y_m: 2, yaw_rad: 3 } }\n"
            : "  trajectory: { path: log, columns: { time: 0, x_m: 1, y_m: 2, q_x: 4, q_y: 5, q_z: 6, q_w: 7 } }\n";
  }
  read_source(waymark_plugin_csv, yaml, kRig);
}

const Harness kHarness("csv", run);

}  // namespace
}  // namespace waymark::fuzz::csv_harness
