// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "apps/waymark/command/command_line.hpp"
#include "apps/waymark/command/commands.hpp"
#include "apps/waymark/command/map_edit.hpp"
#include "apps/waymark/command/map_errors.hpp"
#include "apps/waymark/evaluation/trajectory_io.hpp"
#include "apps/waymark/maps/conversion.hpp"
#include "apps/waymark/maps/octree_file.hpp"
#include "apps/waymark/maps/octree_picture.hpp"
#include "plugins/shared/map_formats/landmark_list.hpp"
#include "plugins/shared/map_formats/map_manifest.hpp"
#include "plugins/shared/map_formats/map_server.hpp"
#include "waymark/base/error.hpp"
#include "waymark/io/output_file.hpp"

namespace waymark::command {

namespace {

namespace fs = std::filesystem;

/// What a map's file is, by its extension.
enum class MapKind { octree, full_octree, grid, landmarks, manifest };

/// Of a feature map, as the sink map_files writes it.
bool is_landmark_yaml(const fs::path& file) { return file.filename().string().ends_with(".landmarks.yaml"); }

MapKind kind_of(const fs::path& file) {
  if (is_landmark_yaml(file)) return MapKind::landmarks;
  const std::string extension = file.extension().string();
  if (extension == ".bt") return MapKind::octree;
  if (extension == ".ot") return MapKind::full_octree;
  if (extension == ".yaml" || extension == ".yml")
    return map_formats::is_manifest(file) ? MapKind::manifest : MapKind::grid;
  if (extension == ".csv") return MapKind::landmarks;
  throw Error(
      fmt::format("{}: \"{}\" is not an extension of a map; .bt, .ot, .yaml (with its .pgm), .landmarks.yaml or .csv "
                  "(landmarks) is expected",
                  file.string(), extension));
}

double megabytes(std::size_t bytes) { return static_cast<double>(bytes) / 1e6; }

void print_octree(const fs::path& file) {
  const maps::LoadedOctree loaded = maps::read_octree(file);
  const octomap::OcTree& tree = *loaded.tree;
  const maps::OctreeFigures figures = maps::figures_of(tree);
  const double resolution = tree.getResolution();
  std::array<double, 3> size{};
  for (std::size_t axis = 0; axis < 3; ++axis) size[axis] = figures.high_m[axis] - figures.low_m[axis];
  print_output("kind        octree of OctoMap, {}\n", loaded.format == map_formats::OctreeFormat::binary
                                                          ? "voxels occupied or free (.bt)"
                                                          : "voxels with log-odds (.ot)");
  print_output("resolution  {:g} m\n", resolution);
  print_output("size        {:.3f} x {:.3f} x {:.3f} m, {:.0f} x {:.0f} x {:.0f} voxels\n", size[0], size[1], size[2],
               size[0] / resolution, size[1] / resolution, size[2] / resolution);
  print_output("origin      x {:.3f} y {:.3f} z {:.3f} m, the lower corner of what is known\n", figures.low_m[0],
               figures.low_m[1], figures.low_m[2]);
  print_output("nodes       {}, of them {} leaves\n", tree.size(), figures.leaves);
  print_output("occupied    {} voxels\nfree        {} voxels\nunknown     {} voxels within that size\n",
               figures.occupied, figures.free, figures.unknown);
  print_output("memory      {:.1f} MB\n", megabytes(tree.memoryUsage()));
}

void print_grid(const fs::path& file) {
  const GridView grid = map_formats::read_map_server(file);
  const auto occupied = std::ranges::count(grid.cells, 100);
  const auto unknown = std::ranges::count(grid.cells, GridView::kUnknown);
  print_output("kind        grid of map_server (YAML with a greymap)\n");
  print_output("resolution  {:g} m\n", grid.resolution_m);
  print_output("size        {:.3f} x {:.3f} m, {} x {} cells\n", grid.width * grid.resolution_m,
               grid.height * grid.resolution_m, grid.width, grid.height);
  print_output("origin      x {:.3f} y {:.3f} m, yaw {:.4f} rad, the lower left corner\n", grid.T_map_grid.p.x(),
               grid.T_map_grid.p.y(), grid.T_map_grid.yaw());
  print_output("occupied    {} cells\nfree        {} cells\nunknown     {} cells\n", occupied,
               static_cast<std::ptrdiff_t>(grid.cells.size()) - occupied - unknown, unknown);
  print_output("memory      {:.1f} MB\n", megabytes(grid.cells.size()));
}

std::vector<evaluation::Landmark> read_landmarks(const fs::path& file) {
  if (!is_landmark_yaml(file)) return evaluation::read_landmarks(file);
  std::vector<evaluation::Landmark> landmarks;
  for (const map_formats::LandmarkEntry& entry : map_formats::read_landmark_list(file))
    landmarks.emplace_back().p_map = entry.mean.head<2>();
  return landmarks;
}

void print_landmarks(const fs::path& file) {
  const std::vector<evaluation::Landmark> landmarks = read_landmarks(file);
  print_output("kind        list of landmarks\n");
  print_output("landmarks   {}\n", landmarks.size());
  if (landmarks.empty()) return;
  const auto x = [](const evaluation::Landmark& one) { return one.p_map.x(); };
  const auto y = [](const evaluation::Landmark& one) { return one.p_map.y(); };
  const double low_x = x(*std::ranges::min_element(landmarks, {}, x));
  const double low_y = y(*std::ranges::min_element(landmarks, {}, y));
  print_output("size        {:.3f} x {:.3f} m, between their middles\n",
               x(*std::ranges::max_element(landmarks, {}, x)) - low_x,
               y(*std::ranges::max_element(landmarks, {}, y)) - low_y);
  print_output("origin      x {:.3f} y {:.3f} m, the lower left corner\n", low_x, low_y);
}

void print_info(const fs::path& file);

void print_manifest(const fs::path& file) {
  const map_formats::MapManifest manifest = map_formats::read_manifest(file);
  print_output("kind        manifest of {} {}\n", manifest.layers.size(),
               manifest.layers.size() == 1 ? "layer" : "layers");
  print_output("frame       {}\n", manifest.datum ? "east, north, up at the datum" : "that in which the robot was");
  print_output("datum       {}\n", map_formats::datum_text(manifest.datum));
  for (const map_formats::MapLayer& layer : manifest.layers) {
    constexpr double kDegrees = 180.0 / std::numbers::pi;
    const Pose& T = layer.T_frame_file;
    print_output("\nlayer       {}\nfile        {}\n", layer.name, layer.file.string());
    print_output("pose        x {:.3f} y {:.3f} z {:.3f} m, yaw {:.3f} deg: where its coordinates lie in the frame\n",
                 T.p.x(), T.p.y(), T.p.z(), T.yaw() * kDegrees);
    if (kind_of(layer.file) == MapKind::manifest)
      throw Error(fmt::format("{}: a manifest is no layer of another one", layer.file.string()));
    print_info(layer.file);
  }
}

void print_info(const fs::path& file) {
  switch (kind_of(file)) {
    case MapKind::manifest:
      return print_manifest(file);
    case MapKind::octree:
    case MapKind::full_octree:
      return print_octree(file);
    case MapKind::grid:
      return print_grid(file);
    case MapKind::landmarks:
      return print_landmarks(file);
  }
}

struct ConvertOptions {
  fs::path in;
  fs::path out;
  std::string layer;            // empty: not given
  std::vector<double> slice_m;  // the same
};

/// The layer that is to be converted: the named one, or the only one that can be.
map_formats::MapLayer layer_of(const ConvertOptions& options) {
  if (!map_formats::is_manifest(options.in)) {
    if (!options.layer.empty())
      throw UsageError(fmt::format("map convert: {} is no manifest, so it has no layers", options.in.string()));
    return {{}, {}, options.in, {}};
  }
  const map_formats::MapManifest manifest = map_formats::read_manifest(options.in);
  std::vector<std::string> names;
  const map_formats::MapLayer* only = nullptr;
  for (const map_formats::MapLayer& layer : manifest.layers) {
    if (layer.name == options.layer) return layer;
    if (layer.format == map_formats::kLandmarksFormat) continue;
    names.push_back(layer.name);
    only = &layer;
  }
  if (options.layer.empty() && names.size() == 1) return *only;
  throw UsageError(fmt::format("map convert: --layer must name one of the layers of {}: {}", options.in.string(),
                               fmt::join(names, ", ")));
}

void write_octree(octomap::OcTree& tree, const fs::path& out) {
  const bool is_full = kind_of(out) == MapKind::full_octree;
  write_file(out, map_formats::octree_text(
                      tree, is_full ? map_formats::OctreeFormat::full : map_formats::OctreeFormat::binary));
  print_output("{}: octree of {:g} m, {} nodes\n", out.string(), tree.getResolution(), tree.size());
}

void write_grid(const GridView& grid, const fs::path& out) {
  fs::path image = out;
  image.replace_extension(".pgm");
  write_file(image, map_formats::greymap_text(grid));
  write_file(out, map_formats::legend_text(grid, image.filename().string()));
  print_output("{}, {}: {} x {} cells of {:g} m\n", out.string(), image.string(), grid.width, grid.height,
               grid.resolution_m);
}

void convert(ConvertOptions options) {
  const map_formats::MapLayer layer = layer_of(options);
  options.in = layer.file;
  const MapKind from = kind_of(options.in);
  const MapKind to = kind_of(options.out);
  if (from == MapKind::manifest || to == MapKind::manifest)
    throw UsageError(
        "map convert: a manifest as a layer, or to be overwritten, is not possible; .bt, .ot and .yaml are");
  const bool is_slice = from != MapKind::grid && to == MapKind::grid;
  if (from == MapKind::landmarks || to == MapKind::landmarks)
    throw UsageError("map convert: a list of landmarks cannot be converted; .bt, .ot and .yaml can");
  if (from == MapKind::grid && to == MapKind::grid)
    throw UsageError(fmt::format("map convert: {} and {} are of one kind", options.in.string(), options.out.string()));
  std::error_code ignored;
  if (fs::equivalent(options.in, options.out, ignored))
    throw UsageError(fmt::format("map convert: {} would overwrite itself", options.in.string()));
  if (is_slice == options.slice_m.empty()) {
    throw UsageError(is_slice
                         ? "map convert: an octree becomes a grid by --slice-m low,high, the heights [m] to look at"
                         : "map convert: --slice-m is for an octree that becomes a grid (.yaml)");
  }
  if (from == MapKind::grid) {
    GridView grid = map_formats::read_map_server(options.in);
    grid.T_map_grid = layer.T_frame_file * grid.T_map_grid;
    const auto tree = about(options.in, [&] { return maps::layer_of(grid); });
    return write_octree(*tree, options.out);
  }
  const maps::LoadedOctree loaded = maps::read_octree(options.in);
  if (!is_slice) return write_octree(*loaded.tree, options.out);
  const maps::Slice slice{options.slice_m[0], options.slice_m[1]};
  GridView grid = about(options.in, [&] { return maps::slice_of(*loaded.tree, slice); });
  grid.T_map_grid = layer.T_frame_file * grid.T_map_grid;
  write_grid(grid, options.out);
}

struct DrawOptions {
  fs::path in;
  fs::path out;
  fs::path path;
  std::vector<double> height_m;  // empty: not given
  maps::OctreeView view;
};

void draw(DrawOptions options) {
  const MapKind kind = kind_of(options.in);
  if (kind != MapKind::octree && kind != MapKind::full_octree)
    throw UsageError(fmt::format("map draw: {}: an octree (.bt, .ot) is expected", options.in.string()));
  if (options.out.extension() != ".png")
    throw UsageError(fmt::format("map draw: {}: a name that ends in .png is expected", options.out.string()));
  if (!options.height_m.empty()) {
    options.view.low_m = options.height_m[0];
    options.view.high_m = options.height_m[1];
  }
  std::vector<Eigen::Vector3d> path;
  if (!options.path.empty()) {
    for (const auto& point : evaluation::read_trajectory(options.path).points) path.push_back(point.pose.p);
  }
  const maps::LoadedOctree loaded = maps::read_octree(options.in);
  const maps::Picture picture = about(options.in, [&] { return maps::picture_of(*loaded.tree, options.view, path); });
  maps::write_png(picture, options.out);
  print_output("{}: {} x {} pixels\n", options.out.string(), picture.width, picture.height);
}

}  // namespace

void add_map_command(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("map", "Inspect maps, convert, draw, crop, merge and move them");
  command->require_subcommand(1);
  command->footer(
      "Example:\n  waymark map info out/hall/maps.yaml\n"
      "  waymark map convert out/hall/hall.bt hall.yaml --slice-m 0.2,1.5\n"
      "  waymark map crop out/hall/maps.yaml half/maps.yaml --box-m 0,0,10,15\n"
      "  waymark map draw out/hall/hall.bt hall.png --height-m -1,2.5");

  auto file = std::make_shared<fs::path>();
  CLI::App* info = command->add_subcommand("info", "What a map's file holds: kind, cells, size, memory");
  info->footer("Example:\n  waymark map info out/hall/maps.yaml\n  waymark map info out/hall/hall.bt");
  info->add_option("file", *file,
                   "maps.yaml of a run, .bt or .ot (OctoMap), .yaml with its .pgm (map_server), or landmarks as "
                   ".landmarks.yaml or .csv")
      ->required();
  info->callback([file, &exit_code] {
    run_on(*file, [&] { print_info(*file); });
    exit_code = kSuccess;
  });

  auto options = std::make_shared<ConvertOptions>();
  CLI::App* convert_command = command->add_subcommand("convert", "Write a map in another format");
  convert_command->footer(
      "Example:\n  waymark map convert hall.bt hall.ot\n"
      "  waymark map convert hall.bt hall.yaml --slice-m 0.2,1.5     (and hall.pgm)\n"
      "  waymark map convert room.yaml room.bt\n"
      "  waymark map convert out/hall/maps.yaml hall.yaml --layer hall --slice-m 0.2,1.5");
  convert_command->add_option("in", options->in, ".bt, .ot, .yaml, or a manifest of such layers")->required();
  convert_command->add_option("out", options->out, ".bt, .ot or .yaml; its extension decides the format")->required();
  convert_command
      ->add_option("--slice-m", options->slice_m,
                   "low,high: an octree's voxels whose middles lie between these heights [m] become the grid")
      ->delimiter(',')
      ->check(finite_number())
      ->expected(2);
  convert_command->add_option("--layer", options->layer,
                              "of a manifest: the layer; a grid comes where the manifest places it");
  convert_command->callback([options, &exit_code] {
    run_on(options->in, [&] { convert(*options); });
    exit_code = kSuccess;
  });

  auto drawing = std::make_shared<DrawOptions>();
  CLI::App* draw_command = command->add_subcommand("draw", "Draw an octree as a picture in three dimensions");
  draw_command->footer("Example:\n  waymark map draw hall.bt hall.png --height-m -1,2.5 --path path.txt");
  draw_command->add_option("in", drawing->in, ".bt or .ot")->required();
  draw_command->add_option("out", drawing->out, "name of the picture, .png")->required();
  draw_command
      ->add_option("--height-m", drawing->height_m, "low,high: only voxels whose middles lie between these heights [m]")
      ->delimiter(',')
      ->check(finite_number())
      ->expected(2);
  draw_command->add_option("--path", drawing->path, "a trajectory of TUM's format that is drawn above the voxels");
  draw_command
      ->add_option("--from-deg", drawing->view.from_deg, "direction from the map to the spectator, 0: east, 90: north")
      ->check(finite_number())
      ->capture_default_str();
  draw_command->add_option("--tilt-deg", drawing->view.tilt_deg, "0: seen from the side, 90: from above")
      ->check(CLI::Range(0.0, 90.0))
      ->capture_default_str();
  draw_command->add_option("--width-px", drawing->view.width_px, "width of the picture")
      ->check(CLI::Range(100, 10000))
      ->capture_default_str();
  draw_command->callback([drawing, &exit_code] {
    run_on(drawing->in, [&] { draw(*drawing); });
    exit_code = kSuccess;
  });

  add_map_edits(*command, exit_code);
}

}  // namespace waymark::command
