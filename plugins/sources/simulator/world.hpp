// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <vector>

#include "ground.hpp"
#include "texture.hpp"

namespace waymark::simulator {

/// A vertical cylinder that stands on the ground.
struct Cylinder {
  Eigen::Vector2d center;  ///< in the map [m]
  double radius_m;
  double height_m = 3.0;    ///< of its top in the map, here and below
  std::size_t texture = 0;  ///< index into `World::textures`
  double base_m = 0.0;      ///< height of its lower end
};

/// An upright box that stands on the ground or on a floor.
struct Box {
  Eigen::Vector2d center;  ///< in the map [m]
  Eigen::Vector2d half_m;  ///< half its length and half its width
  double yaw_rad;          ///< of its length
  double height_m;
  std::size_t texture = 0;
  double base_m = 0.0;
};

/// A thin upright wall.
struct Wall {
  Eigen::Vector2d from;  ///< in the map [m]
  Eigen::Vector2d to;
  double height_m;
  std::size_t texture = 0;
  double base_m = 0.0;
};

/// Where a horizontal ray meets a thing, seen from above.
struct Hit {
  double enter_m;           ///< along the ray
  double leave_m;           ///< where the ray leaves the thing again
  double height_m;          ///< of the thing
  std::size_t texture;      ///< of its surface
  double tile_u;            ///< place along its outline, in tiles
  double tile_m;            ///< side of a tile on this surface
  Eigen::Vector2d outward;  ///< unit normal at `enter_m`
};

/// What stands around the robot.
struct World {
  static constexpr double kNothing = std::numeric_limits<double>::infinity();
  static constexpr std::size_t kSurroundings = 4;  ///< textures of stones, boxes, walls and ground

  std::vector<Cylinder> landmarks;  ///< the true landmarks, in the order of their names
  std::vector<Cylinder> stones;     ///< this and what follows is not a landmark
  std::vector<Box> boxes;
  std::vector<Wall> walls;
  std::vector<Texture> textures;  ///< the landmarks' classes first, then those of the rest; the last is the ground's
  std::vector<bool> metal;        ///< per texture
  bool has_ground = true;         ///< the ground is there to be seen from above
  double ceiling_m = kNothing;    ///< height of a ceiling over all of it
  Ground ground;                  ///< z = 0, and what is not level about it

  /// Distance [m] in the plane from `origin` to the first surface in direction `angle_rad` (map frame,
  /// counter-clockwise from east) that is higher than the origin, or `kNothing`. From inside a cylinder its wall is
  /// seen. For worlds with level ground.
  double cast(const Eigen::Vector3d& origin, double angle_rad) const;

  /// Distance [m] from `origin` to the first surface in the unit vector `direction`, or `kNothing`: what stands there
  /// is solid from its base up to its height, walls are thin; ground and ceiling have no end. From inside a thing its
  /// surface is seen.
  double cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;

  /// All that a ray meets in front of `origin`, nearest first, in place of what `hits` held. What surrounds the origin
  /// is not met.
  void trace(const Eigen::Vector2d& origin, double angle_rad, std::vector<Hit>& hits) const;
};

}  // namespace waymark::simulator
