// SPDX-License-Identifier: Apache-2.0
// Bags of ROS 2: a database, one whose messages are packed, and the metadata of the folder.
#include <array>
#include <string>

#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/input.hpp"
#include "tests/fuzz/source.hpp"

extern "C" const waymark::PluginDescriptor waymark_plugin_rosbag2;

namespace waymark::fuzz::rosbag2_harness {
namespace {

constexpr std::string_view kPlain =
    "rosbag2_bagfile_information:\n  relative_file_paths: [bag_0.db3]\n  compression_format: \"\"\n"
    "  compression_mode: \"\"\n";
constexpr std::string_view kPacked =
    "rosbag2_bagfile_information:\n  relative_file_paths: [bag_0.db3]\n  compression_format: zstd\n"
    "  compression_mode: MESSAGE\n";

void run(std::string_view input) {
  static const Rig kRig({{"imu", "", Pose{}}, {"gps", "", {}}, {"wheels", "", {}}});
  const Choice choice = choose(input, 3);
  write("bag/metadata.yaml", choice.which == 0 ? kPlain : choice.which == 1 ? kPacked : choice.rest);
  // With metadata under test the part is not a bag: whether it is found is all.
  write("bag/bag_0.db3", choice.which == 2 ? "no database" : choice.rest);
  read_source(waymark_plugin_rosbag2,
              "file: bag\nmax_bad_records: 1000\nchannels: [{ topic: /imu, sensor: imu }, { topic: /fix, sensor: gps "
              "}, { topic: /odom, sensor: wheels }]\n",
              kRig, {.max_ahead = kMaxAheadOfRecording});
}

const Harness kHarness("rosbag2", run);

}  // namespace
}  // namespace waymark::fuzz::rosbag2_harness
