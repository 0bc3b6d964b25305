// SPDX-License-Identifier: Apache-2.0
// Sentences of NMEA 0183, read with one of several configurations.
#include <array>

#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/input.hpp"
#include "tests/fuzz/source.hpp"

extern "C" const waymark::PluginDescriptor waymark_plugin_nmea;

namespace waymark::fuzz::nmea_harness {
namespace {
constexpr std::array kConfigurations{
    // Without checksums, so that changed sentences get past them.
    "file: log\nmax_bad_records: 100000\nrequire_checksum: false\ngnss: { sensor: gps }\n"
    "heading: { sensor: compass }\n",
    "file: log\nmax_bad_records: 2\nrequire_checksum: false\nstart_date: 2024-12-31\ndelay_s: 0.1\n"
    "gnss: { sensor: gps }\nheading: { sensor: compass, time: next }\n",
    "file: log\ngnss: { sensor: gps }\nmax_time_jump_s: 9e9\n",
};

void run(std::string_view input) {
  static const Rig kRig({{"gps", "", {}}, {"compass", "", {}}});
  const Choice choice = choose(input, kConfigurations.size());
  write("log", choice.rest);
  read_source(waymark_plugin_nmea, kConfigurations[choice.which], kRig);
}

const Harness kHarness("nmea", run);

}  // namespace
}  // namespace waymark::fuzz::nmea_harness
