// SPDX-License-Identifier: Apache-2.0
// A log that the sink `log` wrote, read as its source.yaml says; the first byte of an input says which file the rest
// is.
#include <array>
#include <string>

#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/input.hpp"
#include "tests/fuzz/source.hpp"

extern "C" const waymark::PluginDescriptor waymark_plugin_csv;

namespace waymark::fuzz::log_harness {
namespace {
struct File {
  const char* name;
  std::string_view content;
};

constexpr std::array kFiles{
    File{"wheels.csv", "t_ns,arrival_ns,left_mps,right_mps\n0,0,0.01,-0.04\n25000000,25000000,0.05,\n"},
    File{"gps.csv",
         "t_ns,arrival_ns,east_m,north_m,latitude_deg,longitude_deg,hdop,satellites,type,speed_mps,course_rad\n"
         "155000000,155000000,0.1,-0.7,,,,,2,,\n655000000,655000000,,,49.0,8.1,1.5,7,4,0.5,1\n"},
    File{"lidar.csv", "t_ns,arrival_ns,r0,r1,r2,i0,i1,i2\n114000000,114000000,16,inf,nan,0,1,2\n"},
    File{"camera.csv", "t_ns,arrival_ns,file\n100,200,camera/000000.png\n"},
    File{"camera/000000.png", "picture"},
    File{"tags.csv",
         "t_ns,arrival_ns,range_m,bearing_rad,radius_m,identity\n1,1,2.5,0.1,,7\n1,1,3,0.2,0.1,\n2,2,,,,\n"},
    File{"reference_trajectory.csv", "t_ns,x_m,y_m,yaw_rad\n0,0,0,0\n50000000,0.1,0,\n"},
    File{"reference_landmarks.csv", "name,x_m,y_m,radius_m\nc1,-3.2,12.9,0.17\n#2,1.7,6.8,\n"},
};

constexpr const char* kSource = R"(max_bad_rows: 100
max_time_jump_s: 9e9
max_ahead_s: 9e9
files:
  - path: "wheels.csv"
    sensor: "wheels"
    payload: WheelSpeeds
    time: { column: t_ns, scale: 1e-9 }
    arrival: { column: arrival_ns, scale: 1e-9 }
    keep_invalid: true
    columns: { left_mps: left_mps, right_mps: right_mps }
  - path: "gps.csv"
    sensor: "gps"
    payload: GnssFix
    time: { column: t_ns, scale: 1e-9 }
    arrival: { column: arrival_ns, scale: 1e-9 }
    empty_is_unknown: true
    columns:
      east_m: east_m
      north_m: north_m
      latitude_deg: latitude_deg
      longitude_deg: longitude_deg
      hdop: hdop
      satellites: satellites
      type: { column: type, map: { 0: none, 1: single, 2: differential, 3: rtk_float, 4: rtk_fixed, 5: unknown } }
      speed_mps: speed_mps
      course_rad: course_rad
  - path: "lidar.csv"
    sensor: "lidar"
    payload: LaserScan
    time: { column: t_ns, scale: 1e-9 }
    arrival: { column: arrival_ns, scale: 1e-9 }
    scan: { start_rad: -2.3, step_rad: 0.0087, beam_interval_s: 0, allow_non_finite: true }
    columns: { ranges_m: { first: r0, count: 3 }, intensities: { first: i0, count: 3 } }
  - path: "camera.csv"
    sensor: "camera"
    payload: Image
    time: { column: t_ns, scale: 1e-9 }
    arrival: { column: arrival_ns, scale: 1e-9 }
    columns: { file: file }
  - path: "tags.csv"
    sensor: "tags"
    payload: LandmarkObservations
    time: { column: t_ns, scale: 1e-9 }
    arrival: { column: arrival_ns, scale: 1e-9 }
    group_by_time: true
    empty_is_unknown: true
    columns: { range_m: range_m, bearing_rad: bearing_rad, radius_m: radius_m, identity: identity }
reference:
  trajectory:
    path: reference_trajectory.csv
    empty_is_unknown: true
    columns: { time: { column: t_ns, scale: 1e-9 }, x_m: x_m, y_m: y_m, yaw_rad: yaw_rad }
  landmarks:
    path: reference_landmarks.csv
    comment: ""
    empty_is_unknown: true
    columns: { name: name, x_m: x_m, y_m: y_m, radius_m: radius_m }
)";

void run(std::string_view input) {
  static const Rig kRig(
      {{"wheels", "", {}}, {"gps", "", {}}, {"lidar", "", Pose{}}, {"camera", "", Pose{}}, {"tags", "", Pose{}}});
  const Choice choice = choose(input, kFiles.size());
  for (std::size_t i = 0; i < kFiles.size(); ++i)
    write(kFiles[i].name, i == choice.which ? choice.rest : kFiles[i].content);
  read_source(waymark_plugin_csv, kSource, kRig, {.valid_numbers = false, .are_past = false});
}

const Harness kHarness("log", run);

}  // namespace
}  // namespace waymark::fuzz::log_harness
