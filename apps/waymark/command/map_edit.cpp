// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/command/map_edit.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <numbers>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "apps/waymark/command/command_line.hpp"
#include "apps/waymark/command/commands.hpp"
#include "apps/waymark/command/map_errors.hpp"
#include "apps/waymark/maps/map_edits.hpp"
#include "waymark/base/error.hpp"

namespace waymark::command {

namespace {

namespace fs = std::filesystem;

struct EditOptions {
  fs::path in;
  fs::path other;  // of merge
  fs::path out;
  std::vector<double> box_m;
  std::vector<double> height_m;
  double same_landmark_m = 0.5;
  std::vector<double> datum;
  std::vector<double> pose;
};

/// Layers get the names of the map in the YAML, so another manifest in the same folder would share them.
void require_elsewhere(const fs::path& in, const fs::path& out, bool is_manifest, const char* command) {
  std::error_code ignored;
  const auto folder = [](const fs::path& file) {
    return file.parent_path().empty() ? fs::path(".") : file.parent_path();
  };
  if (is_manifest ? fs::equivalent(folder(in), folder(out), ignored) : fs::equivalent(in, out, ignored)) {
    throw UsageError(fmt::format("map {}: {} would overwrite what {} consists of; another {} is expected", command,
                                 out.string(), in.string(), is_manifest ? "folder" : "name"));
  }
}

void write_map(maps::LayeredMap map, const fs::path& out) {
  std::vector<std::string> names;
  for (const fs::path& file : maps::write_layered_map(std::move(map), out)) names.push_back(file.string());
  print_output("{}\n", fmt::join(names, ", "));
}

void crop_map(const EditOptions& options) {
  maps::Box box{options.box_m[0], options.box_m[1], options.box_m[2], options.box_m[3]};
  if (!(box.west < box.east && box.south < box.north))
    throw UsageError("map crop: --box-m needs west < east and south < north");
  if (!options.height_m.empty()) {
    if (!(options.height_m[0] < options.height_m[1])) throw UsageError("map crop: --height-m needs low < high");
    box.low = options.height_m[0];
    box.high = options.height_m[1];
  }
  maps::LayeredMap map = maps::read_layered_map(options.in);
  require_elsewhere(options.in, options.out, map.is_manifest, "crop");
  run_on(options.in, [&] { about(options.in, [&] { maps::crop(map, box); }); });
  write_map(std::move(map), options.out);
}

void merge_maps(const EditOptions& options) {
  maps::LayeredMap map = maps::read_layered_map(options.in);
  const maps::LayeredMap other = maps::read_layered_map(options.other);
  require_elsewhere(options.in, options.out, map.is_manifest, "merge");
  require_elsewhere(options.other, options.out, map.is_manifest, "merge");
  run_on(options.other, [&] { about(options.other, [&] { maps::merge(map, other, options.same_landmark_m); }); });
  write_map(std::move(map), options.out);
}

void georeference_map(const EditOptions& options) {
  maps::LayeredMap map = maps::read_layered_map(options.in);
  require_elsewhere(options.in, options.out, map.is_manifest, "georeference");
  Pose T_to_from;
  if (!options.pose.empty())
    T_to_from = Pose::planar(options.pose[0], options.pose[1], options.pose[2] * std::numbers::pi / 180.0);
  if (map.is_manifest) {
    if (options.datum.empty()) throw UsageError("map georeference: a manifest needs --datum latitude,longitude,height");
    const Datum datum{options.datum[0], options.datum[1], options.datum[2]};
    if (std::abs(datum.latitude_deg) > 90.0 || std::abs(datum.longitude_deg) > 180.0) {
      throw UsageError(
          fmt::format("map georeference: --datum {},{}: a latitude from -90 to 90 and a longitude from -180 "
                      "to 180 are expected",
                      datum.latitude_deg, datum.longitude_deg));
    }
    if (map.datum) {
      if (!options.pose.empty())
        throw UsageError("map georeference: --pose is for a map without a datum; this one lies where its datum says");
      run_on(options.in, [&] { about(options.in, [&] { T_to_from = maps::between(datum, *map.datum); }); });
    }
    map.datum = datum;
  } else {
    if (!options.datum.empty())
      throw UsageError("map georeference: a single layer has no place for a datum; give its manifest, or --pose alone");
    if (options.pose.empty()) throw UsageError("map georeference: a single layer needs --pose x,y,yaw");
    if (std::holds_alternative<maps::LoadedOctree>(map.layers.front().content))
      throw UsageError(
          "map georeference: the file of an octree has no place for a pose; give the manifest that names it");
  }
  maps::move(map, T_to_from);
  write_map(std::move(map), options.out);
}

constexpr const char* kMapToEdit = "maps.yaml of a run, or one layer: .landmarks.yaml, .yaml (map_server), .bt, .ot";
constexpr const char* kEditedMap = "of the same kind; a manifest in another folder, its layers are written beside it";

void add_crop(CLI::App& map_command, int& exit_code) {
  auto options = std::make_shared<EditOptions>();
  CLI::App* command = map_command.add_subcommand("crop", "Leave what lies in a box");
  command->footer(
      "Example:\n  waymark map crop out/yard/maps.yaml half/maps.yaml --box-m 0,-4,20,13\n"
      "  waymark map crop hall.bt low.bt --box-m -8,-8,31,8 --height-m 0,2");
  command->add_option("in", options->in, kMapToEdit)->required();
  command->add_option("out", options->out, kEditedMap)->required();
  command->add_option("--box-m", options->box_m, "west,south,east,north: middles of landmarks, cells, voxels [m]")
      ->delimiter(',')
      ->check(finite_number())
      ->expected(4)
      ->required();
  command->add_option("--height-m", options->height_m, "low,high: of octrees, too [m]")
      ->delimiter(',')
      ->check(finite_number())
      ->expected(2);
  command->callback([options, &exit_code] {
    crop_map(*options);
    exit_code = kSuccess;
  });
}

void add_merge(CLI::App& map_command, int& exit_code) {
  auto options = std::make_shared<EditOptions>();
  CLI::App* command = map_command.add_subcommand("merge", "Make one map of two in the same frame");
  command->footer(
      "Example:\n  waymark map merge monday/maps.yaml tuesday/maps.yaml both/maps.yaml\n"
      "  waymark map merge a.landmarks.yaml b.landmarks.yaml both.landmarks.yaml");
  command->add_option("first", options->in, kMapToEdit)->required();
  command->add_option("second", options->other, "the same; layers of one name become one")->required();
  command->add_option("out", options->out, kEditedMap)->required();
  command
      ->add_option("--same-landmark-m", options->same_landmark_m,
                   "of two landmarks that are closer the one with the smaller covariance stays [m]")
      ->check(non_negative_number())
      ->capture_default_str();
  command->callback([options, &exit_code] {
    merge_maps(*options);
    exit_code = kSuccess;
  });
}

void add_georeference(CLI::App& map_command, int& exit_code) {
  auto options = std::make_shared<EditOptions>();
  CLI::App* command = map_command.add_subcommand("georeference", "Give a map its place on the Earth, or another datum");
  command->footer(
      "Example:\n  waymark map georeference out/hall/maps.yaml placed/maps.yaml --datum 48.1,11.5,520 --pose "
      "12.5,-3,90\n"
      "  waymark map georeference out/yard/maps.yaml moved/maps.yaml --datum 48.1,11.5,520\n"
      "  waymark map georeference room.yaml turned.yaml --pose 0,0,90");
  command->add_option("in", options->in, kMapToEdit)->required();
  command->add_option("out", options->out, kEditedMap)->required();
  command->add_option("--datum", options->datum, "latitude,longitude,height of the new origin [deg, deg, m]")
      ->delimiter(',')
      ->check(finite_number())
      ->expected(3);
  command
      ->add_option("--pose", options->pose,
                   "x,y,yaw: where the old origin lies in the new frame, of a map without a datum [m, m, deg]")
      ->delimiter(',')
      ->check(finite_number())
      ->expected(3);
  command->callback([options, &exit_code] {
    georeference_map(*options);
    exit_code = kSuccess;
  });
}

}  // namespace

void add_map_edits(CLI::App& map_command, int& exit_code) {
  add_crop(map_command, exit_code);
  add_merge(map_command, exit_code);
  add_georeference(map_command, exit_code);
}

}  // namespace waymark::command
