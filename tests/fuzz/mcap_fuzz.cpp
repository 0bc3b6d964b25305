// SPDX-License-Identifier: Apache-2.0
// MCAP files: topics of ROS 2, fields of a recorded definition, flight records; plain or packed as a whole.
#include <array>
#include <string>

#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/input.hpp"
#include "tests/fuzz/source.hpp"

extern "C" const waymark::PluginDescriptor waymark_plugin_mcap;

namespace waymark::fuzz::mcap_harness {
namespace {

struct Case {
  const char* file;
  const char* channels;
};

constexpr const char* kTopics =
    "channels: [{ topic: /imu, sensor: imu }, { topic: /fix, sensor: gps, stamp: recorded }, { topic: /scan, sensor: "
    "lidar }]\nmax_bad_records: 1000\n";
constexpr const char* kFields =
    "channels: [{ topic: /dvl, sensor: wheels, payload: BodyTwist, fields: { v_x_mps: velocity.x, w_z_radps: -rate } "
    "}]\nmax_bad_records: 1000\n";
constexpr const char* kFlight = "max_bad_records: 1000\n";
constexpr std::array kCases{Case{"log.mcap", kTopics}, Case{"log.mcap", kFields}, Case{"log.mcap", kFlight},
                            Case{"log.mcap.zst", kTopics}, Case{"log.mcap.gz", kFlight}};

void run(std::string_view input) {
  static const Rig kRig({{"imu", "", Pose{}}, {"gps", "", {}}, {"lidar", "", Pose{}}, {"wheels", "", {}}});
  const Choice choice = choose(input, kCases.size());
  const auto& [file, channels] = kCases[choice.which];
  write(file, choice.rest);
  // A record holds what a robot measured, with whatever stamps and sequence numbers that had.
  const bool is_flight = channels == kFlight;
  const Demands demands{.are_past = !is_flight, .in_sequence = !is_flight, .max_ahead = kMaxAheadOfRecording};
  read_source(waymark_plugin_mcap, "file: " + std::string(file) + "\n" + channels, kRig, demands);
}

const Harness kHarness("mcap", run);

}  // namespace
}  // namespace waymark::fuzz::mcap_harness
