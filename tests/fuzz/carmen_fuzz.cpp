// SPDX-License-Identifier: Apache-2.0
// Logs of CARMEN, read with one of several configurations.
#include <array>

#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/input.hpp"
#include "tests/fuzz/source.hpp"

extern "C" const waymark::PluginDescriptor waymark_plugin_carmen;

namespace waymark::fuzz::carmen_harness {
namespace {
constexpr std::array kConfigurations{
    "file: log\nmax_bad_records: 1000\n"
    "lasers: [{ message: FLASER, sensor: front }, { message: RLASER, sensor: rear }]\n"
    "wheels: { sensor: wheels, poses: all }\ngnss: { sensor: gps }\n",
    "file: log\nmax_bad_records: 3\ntimes: logger\n"
    "lasers: [{ message: ROBOTLASER1, sensor: front, start_deg: -90, step_deg: 1 }]\nwheels: { sensor: wheels }\n",
    "file: log\nmax_bad_records: 1000\ntimes: lines\nlasers: [{ message: ROBOTLASER1, sensor: front }]\n"
    "wheels: { sensor: wheels, poses: odom, reversals: as_logged }\n",
};

void run(std::string_view input) {
  static const Rig kRig({{"front", "", Pose{}}, {"rear", "", Pose{}}, {"wheels", "", {}}, {"gps", "", {}}});
  const Choice choice = choose(input, kConfigurations.size());
  write("log", choice.rest);
  read_source(waymark_plugin_carmen, kConfigurations[choice.which], kRig);
}

const Harness kHarness("carmen", run);

}  // namespace
}  // namespace waymark::fuzz::carmen_harness
