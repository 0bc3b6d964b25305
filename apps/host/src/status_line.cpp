// SPDX-License-Identifier: Apache-2.0
#include "status_line.hpp"

#include <fmt/format.h>

#include <array>
#include <cstddef>
#include <nlohmann/json.hpp>

namespace waymark::host {

std::string status_line(const Fusion& fusion, const Robot& robot, const LiveReport& live, Duration silence) {
  const Health& health = fusion.health();
  nlohmann::ordered_json json{
      {"started", fusion.started()}, {"health", to_string(health.state)}, {"reason", health.reason}};
  if (!fusion.started()) {
    // The filter's own health begins with its start.
    json["health"] = to_string(Health::State::lost);
    json["reason"] = "the filter has not started";
  }
  if (silence > Duration::zero()) {
    json["health"] = to_string(Health::State::lost);
    json["reason"] = fmt::format("nothing has arrived for {:.1f} s", to_seconds(silence));
  }
  fusion.visit_last([&](const Snapshot& last) {
    if (!last.started()) return;
    const Pose& pose = last.belief().mean.T_map_base;
    json["stamp_ns"] = last.stamp().time_since_epoch().count();
    json["x_m"] = pose.p.x();
    json["y_m"] = pose.p.y();
    json["yaw_rad"] = pose.yaw();
  });
  json["measurements"] = fusion.arrived();
  json["cpu_share"] = live.cpu_share;
  json["front_latency_s"] = {live.front_latency_s.median, live.front_latency_s.p99, live.front_latency_s.max};
  for (std::size_t i = 0; i < robot.sensors.size(); ++i) {
    constexpr std::array<const char*, 3> kModeWords{"fused", "shadow", "off"};
    const SensorMode mode = fusion.mode(static_cast<std::uint32_t>(i));
    nlohmann::ordered_json& sensor = json["sensors"][robot.sensors[i].name];
    sensor["mode"] = kModeWords[static_cast<std::size_t>(mode)];
    if (i < health.sensors.size()) sensor["health"] = to_string(health.sensors[i].state);
  }
  for (std::size_t i = 0; i < robot.maps.size(); ++i)
    json["maps"][robot.maps[i].name]["mode"] = fusion.map_enabled(i) ? "on" : "off";
  for (const LiveReport::Stream& stream : live.streams) {
    nlohmann::ordered_json& sensor = json["sensors"][stream.sensor];
    sensor["received"] = stream.received;
    sensor["dropped"] = stream.dropped;
    sensor["missing"] = stream.missing;
    sensor["waits"] = stream.waits;
    sensor["latency_s"] = {stream.latency_s.median, stream.latency_s.p99, stream.latency_s.max};
    sensor["clock_offset_s"] = stream.clock_offset_s;
    sensor["clock_drift"] = stream.clock_drift;
  }
  return json.dump();
}

}  // namespace waymark::host
