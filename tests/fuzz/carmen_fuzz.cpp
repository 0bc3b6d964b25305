// SPDX-License-Identifier: Apache-2.0
// Logs of CARMEN, read with one of several configurations.
#include <array>

#include "input.hpp"
#include "source.hpp"

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

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace waymark;
  static const Rig kRig({{"front", "", Pose{}}, {"rear", "", Pose{}}, {"wheels", "", {}}, {"gps", "", {}}});
  const fuzz::Choice choice = fuzz::choose(fuzz::text_of(data, size), kConfigurations.size());
  fuzz::write("log", choice.rest);
  fuzz::read_source(kConfigurations[choice.which], kRig);
  return 0;
}
