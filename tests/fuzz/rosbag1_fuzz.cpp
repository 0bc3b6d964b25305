// SPDX-License-Identifier: Apache-2.0
// Bags of ROS 1, read with one of several configurations.
#include <array>

#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/input.hpp"
#include "tests/fuzz/source.hpp"

extern "C" const waymark::PluginDescriptor waymark_plugin_rosbag1;

namespace waymark::fuzz::rosbag1_harness {
namespace {
constexpr std::array kConfigurations{
    "file: log.bag\nmax_bad_records: 1000\nchannels: [{ topic: /x, sensor: a }]\n",
    "file: log.bag\nmax_bad_records: 1000\narrival: stamp\nreorder_window_s: 0.5\n"
    "channels: [{ topic: /x, sensor: a }, { topic: /y, sensor: b, stamp: recorded }]\n",
    "file: log.bag\nchannels: [{ topic: /x, sensor: a, stamp_offset_s: -0.5 }]\n",
};

void run(std::string_view input) {
  static const Rig kRig({{"a", "", Pose{}}, {"b", "", Pose{}}});
  const Choice choice = choose(input, kConfigurations.size());
  write("log.bag", choice.rest);
  read_source(waymark_plugin_rosbag1, kConfigurations[choice.which], kRig, {.max_ahead = kMaxAheadOfRecording});
}

const Harness kHarness("rosbag1", run);

}  // namespace
}  // namespace waymark::fuzz::rosbag1_harness
