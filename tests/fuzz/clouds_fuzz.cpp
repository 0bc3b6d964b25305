// SPDX-License-Identifier: Apache-2.0
// A file of point clouds.
#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/input.hpp"
#include "tests/fuzz/source.hpp"

extern "C" const waymark::PluginDescriptor waymark_plugin_clouds;

namespace waymark::fuzz::clouds_harness {
namespace {

void run(std::string_view input) {
  static const Rig kRig({{"lidar", "waymark/PointCloud@1", Pose{}}});
  write("clouds.bin", input);
  read_source(waymark_plugin_clouds, "file: clouds.bin\nsensor: lidar\nmax_bad_records: 100\n", kRig);
  read_source(waymark_plugin_clouds,
              "file: clouds.bin\nsensor: lidar\nmax_bad_records: 100\nevery_nth_point: 2\nmax_points: 3\n"
              "first_cloud: 1\nstart_s: 0.1\nend_s: 5\n",
              kRig);
}

const Harness kHarness("clouds", run);

}  // namespace
}  // namespace waymark::fuzz::clouds_harness
