// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "waymark/config/config.hpp"
#include "waymark/interface/sensor.hpp"
#include "waymark/math/pose.hpp"

namespace waymark::map_formats {

/// The `version` of the format.
constexpr int kManifestVersion = 1;

/// A layer's `format`.
inline constexpr std::string_view kLandmarksFormat = "landmarks";   ///< `.landmarks.yaml`
inline constexpr std::string_view kMapServerFormat = "map_server";  ///< `.yaml` with its `.pgm`
inline constexpr std::string_view kOctreeFormat = "octree";         ///< `.bt`, `.ot`

/// "landmarks", "map_server", "octree", by the end of a file's name; for others the extension.
std::string layer_format(const std::filesystem::path& file);

/// One map of a robot, as a file.
struct MapLayer {
  std::string name;            ///< of the map in the YAML of the run
  std::string format;          ///< one of the above, or a plugin's own
  std::filesystem::path file;  ///< as it can be opened
  Pose T_frame_file;           ///< where the coordinates of the file lie in the manifest's frame: planar, with a height
};

/// The layers of one map and where they lie: east, north, up at `datum`. Without a datum: the frame in which the robot
/// was, whatever that is on the Earth.
struct MapManifest {
  static constexpr std::size_t kMostLayers = 1000;

  std::filesystem::path file;  ///< the manifest itself
  std::optional<Datum> datum;
  std::vector<MapLayer> layers;

  /// Null if there is none.
  const MapLayer* find(std::string_view name) const;
};

/// True for a YAML that lists layers. False for a file that is no YAML, or that cannot be read.
bool is_manifest(const std::filesystem::path& file);

/// Throws ConfigError with file, line and what was expected.
MapManifest read_manifest(const std::filesystem::path& file);

/// The manifest as YAML, for a file in `folder`: files below it are named from there.
std::string manifest_text(const MapManifest& manifest, const std::filesystem::path& folder);

/// "48.1, 11.5, 500 m", or "none".
std::string datum_text(const std::optional<Datum>& datum);

}  // namespace waymark::map_formats
