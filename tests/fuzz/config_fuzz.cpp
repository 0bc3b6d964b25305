// SPDX-License-Identifier: Apache-2.0
// The YAML of a robot: variables, every kind of read, the host's own keys, overrides of the command line.
#include <algorithm>
#include <string>
#include <vector>

#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/input.hpp"
#include "waymark/config/config.hpp"
#include "waymark/host/fusion_settings.hpp"

namespace waymark::fuzz::config_harness {
namespace {
constexpr const char* kRobot =
    "variables: { a: 1, b: \"${a}2\" }\nmotion: { kind: planar }\nfilter: { particles: 3, seed: \"${a}\" }\n"
    "initial: { x_m: 0, y_m: 0, yaw_deg: 0 }\nsensors:\n  - { name: wheels, plugin: odometry, delay_s: 0.1 }\n";

/// Calls `read`; errors are as good as values.
template <class Read>
void attempt(const Read& read) {
  expect_value_or_error(read);
}

/// Reads every key below a node in every way.
void read_all(const Config& config, int depth) {
  for (const std::string& key : config.keys()) {
    attempt([&] { (void)config.number(key); });
    attempt([&] { (void)config.integer(key); });
    attempt([&] { (void)config.boolean(key); });
    attempt([&] { (void)config.text(key); });
    attempt([&] { (void)config.numbers(key); });
    attempt([&] { (void)config.texts(key); });
    attempt([&] { (void)config.output(key, "file.txt"); });
    if (depth == 0) continue;
    if (config.is_mapping(key)) attempt([&] { read_all(config.child(key), depth - 1); });
    if (config.is_list(key)) {
      attempt([&] {
        for (const Config& item : config.items(key)) read_all(item, depth - 1);
      });
    }
  }
}

void read_robot(const Config& config) {
  attempt([&] { (void)read_fusion_settings(config); });
  attempt([&] {
    std::vector<Mounting> mountings;
    for (const Config& sensor : config.items_or_empty("sensors")) {
      (void)read_sensor_slot(sensor);
      mountings.push_back(read_mounting(sensor));
    }
    const Rig rig(std::move(mountings));
    for (const Config& map : config.items_or_empty("maps")) (void)read_map_slot(map, rig);
  });
}

/// What a run writes beside its results must be readable, and hold what was given.
void check_effective(const Config& config, const std::string& effective) {
  try {
    const Config again = Config::parse(effective, "config.yaml");
    const std::vector<std::string> keys = again.keys();
    for (const std::string& key : config.keys()) {
      if (std::ranges::find(keys, key) == keys.end())
        violation("the effective configuration has no key " + key + ":\n" + effective);
    }
    attempt([&] { read_robot(again); });
  } catch (const Error& error) {
    violation("the effective configuration cannot be read: " + std::string(error.what()) + "\n" + effective);
  }
}

void run(std::string_view input) {
  const Choice choice = choose(input, 2);
  const std::string text(choice.rest);
  expect_value_or_error([&] {
    const Config config =
        choice.which == 0 ? Config::load(write("robot.yaml", text)) : Config::parse(kRobot, "robot.yaml", {text});
    read_robot(config);
    read_all(config, 4);
    const std::string effective = config.effective();
    check_effective(config, effective);
    attempt([&] { config.reject_unread(); });
  });
}

const Harness kHarness("config", run);

}  // namespace
}  // namespace waymark::fuzz::config_harness
