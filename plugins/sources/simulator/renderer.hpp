// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "texture.hpp"
#include "waymark/interface/rig.hpp"
#include "waymark/math/pose.hpp"
#include "world.hpp"

namespace waymark::simulator {

/// Light that falls on the scene.
struct Light {
  double sun_azimuth_rad;    ///< where it comes from, in the map
  double shading;            ///< 0 to 1: how much darker a surface is that faces away from it
  Eigen::Vector3f gain_bgr;  ///< of each channel, exposure included
};

/// Draws a `World` as a camera sees it. All things are upright, so it is enough to know what stands in each azimuth
/// (rays cast in the plane, several to a pixel) and then to find, for each pixel, what its slope meets first.
class Renderer {
 public:
  /// Why a camera with these intrinsics and this orientation cannot be rendered, or empty. Every pixel must look
  /// outwards and none straight up or down.
  static const char* refusal(const Intrinsics& intrinsics, const Eigen::Quaterniond& q_base_camera);

  /// The rays of all pixels are computed once, distortion included. `textures` as in `World`.
  Renderer(const Intrinsics& intrinsics, const Eigen::Quaterniond& q_base_camera, const std::vector<Texture>& textures);

  /// Blue, green, red of all pixels, rows from the top; 1 is full scale and may be exceeded. On level ground the base
  /// stands upright; elsewhere it may lean, but of what is not level about the ground nothing is drawn.
  void render(const World& world, const Pose& T_map_camera, const Light& light, std::vector<Eigen::Vector3f>& image);

 private:
  /// What a pixel may see of one thing in one azimuth.
  struct Slice {
    float enter_m;
    float leave_m;
    float height_m;
    float tile_u;
    float tile_m;
    float shade;
    const Tile* tile;
  };

  struct PixelRay {
    std::uint32_t column;  ///< place in the table of azimuths
    float slope;           ///< height gained per metre in the plane
  };

  void aim(const Eigen::Quaterniond& q_tilt);
  void cast_columns(const World& world, const Pose& T_map_camera, const Light& light);
  Eigen::Vector3f look(std::size_t column, float slope, const Eigen::Vector3d& p_map_camera) const;
  Eigen::Vector3f ground(std::size_t column, float distance_m, float slope, const Eigen::Vector3d& p_map_camera) const;

  std::vector<Tile> tiles_;
  std::vector<Eigen::Vector3d> pixels_;  // directions in the camera's frame
  std::vector<PixelRay> rays_;
  double focal_px_;
  double first_azimuth_rad_ = 0.0;  // of column 0, from where the camera looks
  double column_rad_ = 0.0;
  std::size_t columns_ = 0;

  // Of the image being rendered; kept for their memory.
  std::vector<Slice> slices_;
  std::vector<std::size_t> first_slice_;  // of each column, and the end
  std::vector<Eigen::Vector2f> direction_;
  std::vector<Hit> hits_;
};

}  // namespace waymark::simulator
