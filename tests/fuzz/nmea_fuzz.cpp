// SPDX-License-Identifier: Apache-2.0
// Sentences of NMEA 0183, read with one of several configurations.
#include <array>

#include "input.hpp"
#include "source.hpp"

namespace {

constexpr std::array kConfigurations{
    // Without checksums, so that changed sentences get past them.
    "file: log\nmax_bad_records: 100000\nrequire_checksum: false\ngnss: { sensor: gps }\n"
    "heading: { sensor: compass }\n",
    "file: log\nmax_bad_records: 2\nrequire_checksum: false\nstart_date: 2024-12-31\ndelay_s: 0.1\n"
    "gnss: { sensor: gps }\nheading: { sensor: compass, time: next }\n",
    "file: log\ngnss: { sensor: gps }\nmax_time_jump_s: 9e9\n",
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace waymark;
  static const Rig kRig({{"gps", "", {}}, {"compass", "", {}}});
  const fuzz::Choice choice = fuzz::choose(fuzz::text_of(data, size), kConfigurations.size());
  fuzz::write("log", choice.rest);
  fuzz::read_source(kConfigurations[choice.which], kRig);
  return 0;
}
