// SPDX-License-Identifier: Apache-2.0
// Commands to a running robot, one a line, with measurements between them.
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "apps/host/src/commands.hpp"
#include "tests/fuzz/harness.hpp"
#include "tests/fuzz/input.hpp"
#include "waymark/host/fusion.hpp"
#include "waymark/host/robot.hpp"
#include "waymark/interface/snapshot.hpp"

namespace waymark::fuzz::command_harness {
namespace {

constexpr const char* kRobot = R"(
source:
  plugin: simulator
  duration_s: 3
  course: { waypoints_m: [0, 0, 20, 0] }
  wheels: { sensor: wheels, rate_hz: 10, track_m: 0.5 }
  gps: { sensor: gps, rate_hz: 5, sigma_m: 0.3 }
initial: { x_m: 0, y_m: 0, position_sigma_m: 0.1, yaw_deg: 0, yaw_sigma_deg: 2 }
sensors:
  - { name: wheels, plugin: odometry, model: differential, track_m: 0.5 }
  - { name: gps, plugin: dgps, base_p_antenna_m: [0, 0, 0], sigma_m: 0.3, offset_sigma_m: 0.5, offset_tau_s: 60 }
filter: { history_s: 1, max_latency_s: 0.2 }
)";

void check_pose(const Fusion& fusion) {
  fusion.visit_last([](const Snapshot& last) {
    const Pose& pose = last.belief().mean.T_map_base;
    if (!pose.p.allFinite() || !pose.q.coeffs().allFinite()) violation("the pose is not finite");
  });
}

void run(std::string_view input) {
  constexpr std::size_t kMostCommands = 20;
  static const PluginLoader kLoader({WAYMARK_PLUGIN_DIR});
  static const Config kConfig = Config::parse(kRobot, "robot.yaml");
  static const std::vector<Measurement> kLog = [] {
    const host::Robot robot = host::Robot::load(kConfig, kLoader);
    std::vector<Measurement> log;
    while (auto measurement = robot.source->next()) {
      if (robot.assign(*measurement)) log.push_back(std::move(*measurement));
    }
    return log;
  }();
  const host::Robot robot = host::Robot::live(kConfig, kLoader);
  const std::unique_ptr<Fusion> fusion = robot.fusion(nullptr);
  const host::CommandOutputs outputs{.save_maps = [] { return std::string("maps"); },
                                     .checkpoint = [] { return std::string("file"); },
                                     .status = [] { return std::string("{}"); },
                                     .stop = [] {},
                                     .retune = [](const std::string&) {},
                                     .note_missing = [](std::uint32_t, const host::Gap&) {}};
  std::size_t next = 0;
  for (std::size_t k = 0; k < kMostCommands && !input.empty(); ++k) {
    for (std::size_t i = 0; i < 2 && next < kLog.size(); ++i) fusion->add(kLog[next++]);
    const std::size_t end = std::min(input.find('\n'), input.size());
    const std::string command(input.substr(0, end));
    input.remove_prefix(std::min(end + 1, input.size()));
    (void)host::steers(command);
    const std::string reply = host::execute(command, *fusion, robot, outputs, true);
    if (!reply.starts_with("ok") && !reply.starts_with("error: ")) violation("a reply is neither ok nor an error");
    if (reply.find('\n') != std::string::npos) violation("a reply is not one line: " + reply);
  }
  while (next < kLog.size()) fusion->add(kLog[next++]);
  fusion->finish();
  check_pose(*fusion);
  (void)fusion->report();
}

const Harness kHarness("command", run);

}  // namespace
}  // namespace waymark::fuzz::command_harness
