// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <numbers>

#include "apps/waymark/command/command_line.hpp"
#include "apps/waymark/command/commands.hpp"
#include "waymark/host/robot.hpp"

namespace waymark::command {

namespace {

constexpr double kDegPerRad = 180.0 / std::numbers::pi;

void explain_sensors(const host::Robot& robot) {
  print_output("\nsensors (equal stamps are taken in this order)\n");
  for (std::size_t i = 0; i < robot.sensors.size(); ++i) {
    const SensorSlot& slot = robot.sensors[i];
    const Mounting& mounting = robot.rig.mountings()[i];
    std::string role;
    if (!slot.enabled) {
      role = "switched off";
    } else if (slot.sensor) {
      role = fmt::format("plugin {}{}{}", slot.plugin, slot.sensor->traits().is_motion_source ? ", motion source" : "",
                         slot.sensor->traits().is_absolute ? ", absolute" : "");
      if (const auto block = slot.sensor->block(); !block.empty()) {
        role += ", own states:";
        for (const BlockState& state : block) role += " " + state.name;
      }
      role += fmt::format(", gate {}", slot.gate_probability);
    } else {
      role = fmt::format("{}, for maps only", mounting.payload);
    }
    print_output("  {:<10} {}\n", slot.name, role);
    if (std::ranges::find(robot.mounted_by_robot, slot.name) != robot.mounted_by_robot.end()) {
      print_output("  {:<10} mounted where the robot reports it (from_tf)\n", "");
    } else if (mounting.T_base_sensor) {
      const Eigen::Vector3d rpy = so3::to_rpy(mounting.T_base_sensor->q) * kDegPerRad;
      const Eigen::Vector3d& p = mounting.T_base_sensor->p;
      print_output("  {:<10} at x {:.3f} y {:.3f} z {:.3f} m, roll {:.2f} pitch {:.2f} yaw {:.2f} deg in base_link\n",
                   "", p.x(), p.y(), p.z(), rpy.x(), rpy.y(), rpy.z());
    }
  }
}

void explain_maps(const host::Robot& robot) {
  if (robot.maps.empty()) {
    print_output("\nno maps: a plain asynchronous EKF with one belief\n");
    return;
  }
  print_output("\nmaps (one in each of {} particles)\n", robot.settings.filter.particles);
  for (const MapSlot& map : robot.maps) {
    std::string inputs;
    for (const int input : map.inputs)
      inputs += (inputs.empty() ? "" : ", ") + robot.sensors[static_cast<std::size_t>(input)].name;
    print_output("  {:<10} plugin {}, from {}; {}\n", map.name, map.plugin, inputs,
                 map.localize ? fmt::format("localises with {:.0f} % of the information", 100.0 * map.share)
                              : std::string("maps only"));
  }
}

void check(const std::filesystem::path& file, const std::vector<std::string>& overrides, bool allow_outside) {
  const Config yaml = Config::load(file, overrides);
  if (allow_outside) yaml.permit_outside();
  const host::Robot robot = host::Robot::load(yaml, host::plugin_loader(yaml), host::Mountings::assumed);
  const std::unique_ptr<Fusion> fusion = robot.fusion(nullptr);
  print_output("{}: valid\n", file.string());
  const StateLayout& layout = fusion->layout();
  const int map_states = fusion->georeference_states();
  print_output("\nmotion {}: {} error states, {} of them from sensors' own blocks{}\n",
               layout.motion() == StateLayout::Motion::planar ? "planar (x, y, yaw, v_x, v_y, omega_z)" : "spatial",
               layout.size(), layout.block_size() - map_states,
               map_states > 0 ? fmt::format(", {} the map's place on the Earth (georeference)", map_states) : "");
  explain_sensors(robot);
  explain_maps(robot);
  print_output("\nsinks:");
  for (const host::SinkSlot& sink : robot.sinks) print_output(" {}", sink.plugin);
  print_output("\n");
  for (const std::string& notice : robot.settings.notices) print_output("\nnote: {}\n", notice);
  print_output("\neffective configuration\n\n{}", robot.yaml.effective());
}

}  // namespace

void add_check_command(CLI::App& app, int& exit_code) {
  auto file = std::make_shared<std::filesystem::path>();
  auto overrides = std::make_shared<std::vector<std::string>>();
  CLI::App* command =
      app.add_subcommand("check", "Validate a YAML and explain it: sensors, frames, maps, effective values");
  command->footer("Example:\n  waymark check config/quickstart.yaml --set filter.particles=100");
  command->add_option("config", *file, "the YAML")->required();
  command->add_option("--set", *overrides, "key=value: overrides a key of the YAML");
  auto allow_outside = std::make_shared<bool>(false);
  command->add_flag("--allow-outside", *allow_outside, "files named in the YAML may lie outside of the output folder");
  command->callback([file, overrides, allow_outside, &exit_code] {
    check(*file, *overrides, *allow_outside);
    exit_code = kSuccess;
  });
}

}  // namespace waymark::command
