// SPDX-License-Identifier: Apache-2.0
// live_robot: a robot without a log. The program reads the wheels itself, and requests the present pose.
#include <cstdio>
#include <memory>

#include "waymark/base/error.hpp"
#include "waymark/host/session.hpp"
#include "waymark/interface/payloads.hpp"

using namespace waymark;

namespace {

constexpr const char* kYaml = R"(
initial: { x_m: 0, y_m: 0, yaw_deg: 0 }
sensors:
  - { name: wheels, plugin: odometry, model: twist }
)";

/// One reading of the wheels [m/s, rad/s]; of a real robot it comes from a driver, with the time of the clock.
Measurement wheels(int k) {
  auto twist = std::make_shared<BodyTwist>();
  twist->v_x_mps = 1.0;
  twist->w_z_radps = 0.0;
  Measurement measurement;
  measurement.stamp = measurement.arrival = Time{} + from_seconds(0.1 * (k + 1));
  measurement.sequence = static_cast<std::uint64_t>(k);
  measurement.sensor = 0;  // the index in `sensors:`
  measurement.payload = twist;
  return measurement;
}

}  // namespace

int main() {
  try {
    const PluginLoader loader(PluginLoader::standard_search_path());
    host::Session session(host::Robot::live(Config::parse(kYaml, "live_robot"), loader), {});
    Belief now;
    for (int k = 0; k < 100; ++k) {
      const Measurement reading = wheels(k);
      session.add(reading);
      if (session.fusion().started()) now = session.fusion().front(reading.stamp + from_seconds(0.05));
    }
    std::printf("now at x %.2f m\n", now.mean.T_map_base.p.x());
    return session.finish().failures.empty() ? 0 : 1;
  } catch (const Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
