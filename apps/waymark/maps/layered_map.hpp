// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "octree_file.hpp"
#include "plugins/shared/map_formats/landmark_list.hpp"
#include "waymark/interface/map_view.hpp"
#include "waymark/interface/sensor.hpp"
#include "waymark/math/pose.hpp"

namespace waymark::maps {

using Landmarks = std::vector<map_formats::LandmarkEntry>;

/// A layer with its content.
struct Layer {
  std::string name;
  Pose T_frame_file;  ///< of an octree; landmarks and grids have been moved, so theirs is the identity
  std::variant<Landmarks, GridView, LoadedOctree> content;
};

/// All layers of a manifest, or the one of a single file.
struct LayeredMap {
  std::optional<Datum> datum;
  bool is_manifest = false;
  std::vector<Layer> layers;
};

/// Reads a manifest with its layers, or a `.landmarks.yaml`, a `.yaml` of map_server, a `.bt` or `.ot`. Throws Error
/// with the file, what is wrong and what was expected.
LayeredMap read_layered_map(const std::filesystem::path& file);

/// Writes it: a manifest with the layers beside it, or one file of its kind. Returns the files. Throws Error.
std::vector<std::filesystem::path> write_layered_map(LayeredMap map, const std::filesystem::path& out);

}  // namespace waymark::maps
