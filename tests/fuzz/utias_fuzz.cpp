// SPDX-License-Identifier: Apache-2.0
// Tables of UTIAS MR.CLAM: columns between blanks, read as config/utias_mrclam.yaml does.
#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/input.hpp"
#include "tests/fuzz/source.hpp"

extern "C" const waymark::PluginDescriptor waymark_plugin_csv;

namespace waymark::fuzz::utias_harness {
namespace {
void run(std::string_view input) {
  static const Rig kRig({{"commands", "", {}}, {"camera", "", Pose{}}});
  constexpr const char* kOdometry = "1.0 0.1 0.0\n1.1 0.1 0.2\n1.2 0.0 0.1\n";
  constexpr const char* kMeasurements = "1.0 63 2.0 0.5\n1.0 25 3.0 -0.5\n1.3 5 1.0 0.0\n";
  const Choice choice = choose(input, 2);
  write("odometry", choice.which == 0 ? choice.rest : kOdometry);
  write("measurement", choice.which == 1 ? choice.rest : kMeasurements);
  read_source(waymark_plugin_csv,
              "max_bad_rows: 100\n"
              "files:\n"
              "  - path: odometry\n"
              "    sensor: commands\n"
              "    payload: BodyTwist\n"
              "    time: { column: 0, offset_s: 0.25 }\n"
              "    columns: { v_x_mps: 1, w_z_radps: 2 }\n"
              "    min_step_s: 0.06\n"
              "  - path: measurement\n"
              "    sensor: camera\n"
              "    payload: LandmarkObservations\n"
              "    time: { column: 0, offset_s: -0.05 }\n"
              "    columns: { identity: 1, range_m: 2, bearing_rad: 3 }\n"
              "    group_by_time: true\n"
              "    where: [{ column: 1, not_in: [5, 14, 41, 32, 23] }]\n",
              kRig);
}

const Harness kHarness("utias", run);

}  // namespace
}  // namespace waymark::fuzz::utias_harness
