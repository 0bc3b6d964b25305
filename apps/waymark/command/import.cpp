// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <memory>

#include "apps/waymark/command/command_line.hpp"
#include "apps/waymark/command/commands.hpp"
#include "apps/waymark/import/robot_localization.hpp"

namespace waymark::command {

void add_import_command(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("import", "Write a robot's YAML from the parameters of another program");
  command->require_subcommand(1);
  command->footer("Example:\n  waymark import robot_localization ekf.yaml > robot.yaml && waymark check robot.yaml");

  auto file = std::make_shared<std::filesystem::path>();
  auto settings = std::make_shared<imports::ImportSettings>();
  CLI::App* from = command->add_subcommand("robot_localization", "From the parameters of its ekf_node or ukf_node");
  from->footer(
      "Example:\n  waymark import robot_localization ekf.yaml > robot.yaml\n"
      "  waymark import robot_localization ekf.yaml --recording drive.bag > replay.yaml");
  from->add_option("file", *file, "the YAML of its parameters, of ROS 1 or ROS 2")->required();
  from->add_option("--node", settings->node, "which filter of the file");
  from->add_option("--recording", settings->recording,
                   ".bag, .mcap or folder of rosbag2 that holds the topics, instead of a running robot");
  from->add_option("--fix-topic", settings->fix_topic,
                   "topic of the GPS receiver (NavSatFix), in place of navsat_transform's output");
  from->callback([file, settings, &exit_code] {
    const imports::Imported imported = imports::import_robot_localization(*file, *settings);
    print_text(imported.yaml);
    for (const std::string& note : imported.notes) print_message("waymark: note: {}\n", note);
    exit_code = kSuccess;
  });
}

}  // namespace waymark::command
