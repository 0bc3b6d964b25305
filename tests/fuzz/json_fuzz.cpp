// SPDX-License-Identifier: Apache-2.0
// Payloads as lines of JSON, of every type: what is read is written, and read again.
#include <array>
#include <string>
#include <tuple>

#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/input.hpp"
#include "tests/fuzz/source.hpp"
#include "waymark/interface/payloads.hpp"

extern "C" const waymark::PluginDescriptor waymark_plugin_json;

namespace waymark::fuzz::json_harness {
namespace {

/// One sensor for each payload, which has its short name.
std::string channels() {
  std::string yaml = "channels:\n";
  std::apply(
      [&]<class... P>(const P&...) {
        ((yaml += "  - { sensor: " + std::string(short_type_name(P::kType)) +
                  ", payload: " + std::string(short_type_name(P::kType)) + " }\n"),
         ...);
      },
      CorePayloads());
  return yaml;
}

Rig rig() {
  std::vector<Mounting> mountings;
  std::apply(
      [&]<class... P>(const P&...) {
        (mountings.push_back({std::string(short_type_name(P::kType)), "", Pose{}}), ...);
      },
      CorePayloads());
  return Rig(std::move(mountings));
}

void run(std::string_view input) {
  static const Rig kRig = rig();
  static const std::array kConfigurations{
      "from: file\nfile: log\nmax_bad_records: 100000\nmax_time_jump_s: 9e9\n" + channels(),
      "from: file\nfile: log\nmax_bad_records: 1\nmax_line_bytes: 200\n" + channels()};
  const Choice choice = choose(input, kConfigurations.size());
  write("log", choice.rest);
  read_source(waymark_plugin_json, kConfigurations[choice.which], kRig);
}

const Harness kHarness("json", run);

}  // namespace
}  // namespace waymark::fuzz::json_harness
