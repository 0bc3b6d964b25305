// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <vector>

namespace waymark::evaluation {

/// A surface of the true world: the sides and the top of something upright that stands on z = 0, or a level plane.
struct Surface {
  enum class Kind {
    cylinder,  ///< centre `from`, radius `half_width_m`
    box,       ///< from the middle of one end to that of the other; a thin wall if `half_width_m` is 0
    level      ///< a plane without end
  };
  Kind kind = Kind::level;
  Eigen::Vector2d from = Eigen::Vector2d::Zero();  ///< in the map [m]
  Eigen::Vector2d to = Eigen::Vector2d::Zero();
  double half_width_m = 0.0;
  double height_m = 0.0;
};

/// Reads what the simulator writes as `surfaces_file`: kind,x_m,y_m,x2_m,y2_m,half_width_m,height_m. Throws DataError
/// with file and line.
std::vector<Surface> read_surfaces(const std::filesystem::path& file);

/// Distance [m] from a point to the surface, from inside as from outside.
double distance(const Surface& surface, const Eigen::Vector3d& p);

/// A part of space.
struct Region {
  Eigen::Vector3d low;
  Eigen::Vector3d high;

  bool holds(const Eigen::Vector3d& p) const {
    return (p.array() >= low.array()).all() && (p.array() < high.array()).all();
  }
};

/// Visits points of the surface within the region, at most `spacing_m` apart along each side.
void for_points_on(const Surface& surface, const Region& region, double spacing_m,
                   const std::function<void(const Eigen::Vector3d&)>& visit);

}  // namespace waymark::evaluation
