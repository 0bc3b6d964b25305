// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/map_formats/map_manifest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <numbers>

#include "plugins/shared/map_formats/yaml_text.hpp"
#include "waymark/base/error.hpp"

namespace waymark::map_formats {

namespace {

constexpr double kDegPerRad = 180.0 / std::numbers::pi;
constexpr double kFarthestLayer = 1e8;  // m; beyond, doubles are too coarse for a place
constexpr double kGreatestHeight = 1e5;

Datum read_datum(const Config& config) {
  // Not with commas: what they begin must be finished, and reading may throw.
  Datum datum;
  datum.latitude_deg = config.number_in({"latitude_deg", "°", "of the origin (WGS-84)"}, -90.0, 90.0);
  datum.longitude_deg = config.number_in({"longitude_deg", "°", "of the origin (WGS-84)"}, -180.0, 180.0);
  datum.height_m =
      config.number_in({"height_m", "m", "of the origin, above the ellipsoid"}, -kGreatestHeight, kGreatestHeight, 0.0);
  return datum;
}

Pose read_pose(const Config& layer) {
  const Config config = layer.child_or_empty(
      {"pose", "", "where the coordinates of the file lie in the frame of this manifest", "there"});
  const double x = config.number_in({"x_m", "m", "towards the east"}, -kFarthestLayer, kFarthestLayer, 0.0);
  const double y = config.number_in({"y_m", "m", "towards the north"}, -kFarthestLayer, kFarthestLayer, 0.0);
  const double z = config.number_in({"z_m", "m", "upwards"}, -kGreatestHeight, kGreatestHeight, 0.0);
  const double yaw_deg = config.number_in({"yaw_deg", "°", "counter-clockwise from the east"}, -360.0, 360.0, 0.0);
  Pose pose = Pose::planar(x, y, yaw_deg / kDegPerRad);
  pose.p.z() = z;
  return pose;
}

MapLayer read_layer(const Config& config, const std::filesystem::path& folder) {
  MapLayer layer;
  layer.name = config.text({"name", "of the map"});
  layer.file = config.text({"file", "relative to the manifest"});
  if (layer.name.empty()) config.fail("name", "is empty; the name of a map is expected");
  if (layer.file.empty()) config.fail("file", "is empty; the file of a layer is expected");
  layer.file = folder / layer.file;
  layer.format = config.text({"format", "`landmarks`, `map_server`, `octree`, or that of another plugin"});
  layer.T_frame_file = read_pose(config);
  return layer;
}

bool is_identity(const Pose& pose) {
  return pose.p.isZero(0.0) && pose.q.isApprox(Eigen::Quaterniond::Identity(), 0.0);
}

}  // namespace

std::string layer_format(const std::filesystem::path& file) {
  const std::string name = file.filename().string();
  std::string extension = file.extension().string();
  if (name.ends_with(".landmarks.yaml")) return std::string(kLandmarksFormat);
  if (extension == ".yaml" || extension == ".yml") return std::string(kMapServerFormat);
  if (extension == ".bt" || extension == ".ot") return std::string(kOctreeFormat);
  return extension;
}

const MapLayer* MapManifest::find(std::string_view name) const {
  const auto found = std::ranges::find(layers, name, &MapLayer::name);
  return found == layers.end() ? nullptr : &*found;
}

bool is_manifest(const std::filesystem::path& file) {
  if (layer_format(file) != kMapServerFormat) return false;
  try {
    return Config::load(file).has("layers");
  } catch (const Error&) {
    return false;
  }
}

MapManifest read_manifest(const std::filesystem::path& file) {
  const Config config = Config::load(file);
  if (const std::int64_t version = config.integer({"version", "version of the format"}); version != kManifestVersion) {
    config.fail("version", fmt::format("{} is not {}, the only one that is known", version, kManifestVersion));
  }
  MapManifest manifest;
  manifest.file = file;
  if (config.has("datum"))
    manifest.datum = read_datum(
        config.child({"datum", "", "origin of the frame on the Earth", "none: the frame in which the robot was"}));
  const std::vector<Config> items = config.items({"layers", "the maps, one file each"});
  if (items.empty()) config.fail("layers", "is empty; at least one layer is expected");
  if (items.size() > MapManifest::kMostLayers) {
    config.fail("layers", fmt::format("{} layers; at most {} are expected", items.size(), MapManifest::kMostLayers));
  }
  for (const Config& item : items) {
    MapLayer layer = read_layer(item, file.parent_path());
    if (manifest.find(layer.name) != nullptr)
      item.fail("name", fmt::format("\"{}\" is the name of two layers", layer.name));
    manifest.layers.push_back(std::move(layer));
  }
  config.reject_unread();
  return manifest;
}

std::string manifest_text(const MapManifest& manifest, const std::filesystem::path& folder) {
  std::string text =
      "# The maps of a robot (waymark): `load` of a map and `waymark map` take this file. Coordinates are east, north "
      "and up\n"
      "# at the datum; without one, in the frame in which the robot was.\n";
  auto out = std::back_inserter(text);
  fmt::format_to(out, "version: {}\n", kManifestVersion);
  if (manifest.datum) {
    fmt::format_to(out, "datum: {{ latitude_deg: {}, longitude_deg: {}, height_m: {} }}\n",
                   manifest.datum->latitude_deg, manifest.datum->longitude_deg, manifest.datum->height_m);
  }
  fmt::format_to(out, "layers:\n");
  for (const MapLayer& layer : manifest.layers) {
    const std::filesystem::path relative = layer.file.lexically_proximate(folder);
    fmt::format_to(out, "  - {{ name: {}, format: {}, file: {}", quoted_if_needed(layer.name),
                   quoted_if_needed(layer.format), quoted_if_needed(relative.string()));
    if (!is_identity(layer.T_frame_file)) {
      // Not to the last digits, so that what was read is written again as it was.
      fmt::format_to(out, ", pose: {{ x_m: {:.12g}, y_m: {:.12g}, z_m: {:.12g}, yaw_deg: {:.12g} }}",
                     layer.T_frame_file.p.x(), layer.T_frame_file.p.y(), layer.T_frame_file.p.z(),
                     layer.T_frame_file.yaw() * kDegPerRad);
    }
    fmt::format_to(out, " }}\n");
  }
  return text;
}

std::string datum_text(const std::optional<Datum>& datum) {
  if (!datum) return "none";
  return fmt::format("{}, {}, {} m", datum->latitude_deg, datum->longitude_deg, datum->height_m);
}

}  // namespace waymark::map_formats
