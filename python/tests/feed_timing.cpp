// SPDX-License-Identifier: Apache-2.0
// feed_timing ROBOT.yaml COUNT: adds COUNT readings of wheels to a robot, and prints the CPU time of each [µs].
// feed_timing.py does the same from Python.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>

#include "waymark/base/error.hpp"
#include "waymark/host/session.hpp"
#include "waymark/interface/payloads.hpp"

using namespace waymark;

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  try {
    const Config yaml = Config::load(argv[1]);
    host::Session session(host::Robot::live(yaml, PluginLoader({WAYMARK_PLUGIN_FOLDER})), {});
    const auto count = static_cast<std::uint64_t>(std::atoll(argv[2]));
    const std::clock_t begin = std::clock();
    for (std::uint64_t k = 0; k < count; ++k) {
      auto wheels = std::make_shared<WheelSpeeds>();
      wheels->left_mps = 1.0 + 0.1 * std::sin(0.01 * static_cast<double>(k));
      wheels->right_mps = 1.0;
      Measurement measurement;
      measurement.stamp = measurement.arrival = Time(std::chrono::milliseconds(10 * (k + 1)));
      measurement.sequence = k;
      measurement.payload = std::move(wheels);
      session.add(std::move(measurement));
    }
    const double passed_us = 1e6 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    session.finish();
    std::printf("%.4f\n", passed_us / static_cast<double>(count));
    return 0;
  } catch (const Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
