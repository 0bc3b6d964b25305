// SPDX-License-Identifier: Apache-2.0
// Bags of ROS 1, read with one of several configurations.
#include <array>

#include "input.hpp"
#include "source.hpp"

namespace {

constexpr std::array kConfigurations{
    "file: log.bag\nmax_bad_records: 1000\nchannels: [{ topic: /x, sensor: a }]\n",
    "file: log.bag\nmax_bad_records: 1000\narrival: stamp\nreorder_window_s: 0.5\n"
    "channels: [{ topic: /x, sensor: a }, { topic: /y, sensor: b, stamp: recorded }]\n",
    "file: log.bag\nchannels: [{ topic: /x, sensor: a, stamp_offset_s: -0.5 }]\n",
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace waymark;
  static const Rig kRig({{"a", "", Pose{}}, {"b", "", Pose{}}});
  const fuzz::Choice choice = fuzz::choose(fuzz::text_of(data, size), kConfigurations.size());
  fuzz::write("log.bag", choice.rest);
  fuzz::read_source(kConfigurations[choice.which], kRig);
  return 0;
}
