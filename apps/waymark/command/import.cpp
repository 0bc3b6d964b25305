// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <memory>

#include "apps/waymark/command/command_line.hpp"
#include "apps/waymark/command/commands.hpp"
#include "apps/waymark/import/clouds.hpp"
#include "apps/waymark/import/robot_localization.hpp"

namespace waymark::command {
namespace {

struct CloudOptions {
  imports::CloudImport settings;
  double period_s = 0.1;
  std::string start_s;
};

void import_clouds(CloudOptions& options) {
  options.settings.period = from_seconds(options.period_s);
  if (!options.start_s.empty()) {
    try {
      options.settings.start = parse_time(options.start_s);
    } catch (const DataError& error) {
      throw UsageError(fmt::format("import clouds: --start-s {}: {}", options.start_s, error.what()));
    }
  }
  const imports::ImportedClouds imported = imports::import_clouds(options.settings);
  print_output("{}: {} clouds, {} points{}{}, {:.3f} s from {}\n", options.settings.out.string(), imported.clouds,
               imported.points, imported.intensities ? " with intensity" : "",
               imported.times ? (imported.intensities ? " and time" : " with time") : "",
               to_seconds(imported.last - imported.first), format_time(imported.first));
  for (const std::string& note : imported.notes) print_message("waymark: note: {}\n", note);
}

void add_clouds(CLI::App& command, int& exit_code) {
  auto options = std::make_shared<CloudOptions>();
  CLI::App* clouds = command.add_subcommand("clouds", "A file for the source clouds, from clouds in PCD or CSV");
  clouds->footer(
      "PCD: ascii, binary or binary_compressed. CSV: columns x, y, z, and intensity and t (s) or t_ns if there are\n"
      "such. The times are those of --times, of the names, or evenly spaced.\n"
      "Example:\n  waymark import clouds scans.bin.gz scans/*.pcd --times-in-names\n"
      "  waymark import clouds scans.bin.gz scans/*.csv --times stamps.csv\n"
      "  waymark import clouds scans.bin.gz scans/*.pcd --start-s 1630577758.5 --period-s 0.1");
  clouds->add_option("out", options->settings.out, "the file to write; gzip if its name ends in .gz")->required();
  clouds->add_option("files", options->settings.files, ".pcd or tables, plain or gzip, one cloud each, in order")
      ->required();
  CLI::Option* times = clouds->add_option("--times", options->settings.times,
                                          "table whose first column has the time of each file, in s");
  CLI::Option* names = clouds->add_flag("--times-in-names", options->settings.times_in_names,
                                        "a file's name is its time: 1305031102.175304.pcd, or whole ns");
  CLI::Option* period =
      clouds->add_option("--period-s", options->period_s, "from file to file")->check(positive_number());
  CLI::Option* start = clouds->add_option("--start-s", options->start_s, "time of the first file; 0 without it");
  names->excludes(times)->excludes(period)->excludes(start);
  times->excludes(period)->excludes(start);
  clouds->callback([options, &exit_code] {
    import_clouds(*options);
    exit_code = kSuccess;
  });
}

}  // namespace

void add_import_command(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand(
      "import", "Write a robot's YAML from the parameters of another program, or a file of point clouds");
  command->require_subcommand(1);
  command->footer(
      "Example:\n  waymark import robot_localization ekf.yaml > robot.yaml && waymark check robot.yaml\n"
      "  waymark import clouds scans.bin.gz scans/*.pcd --times-in-names");
  add_clouds(*command, exit_code);

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
