// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <memory>
#include <vector>

namespace waymark::evaluation {

/// One of the waves of uneven ground: z = amplitude sin(k·p + phase).
struct SurfaceWave {
  Eigen::Vector2d k;  ///< [rad/m]
  double phase_rad = 0.0;
  double amplitude_m = 0.0;
};

/// A surface of the true world: the sides and the top of something upright, or a plane.
struct Surface {
  enum class Kind {
    cylinder,  ///< centre `from`, radius `half_width_m`
    box,       ///< from the middle of one end to that of the other; a thin wall if `half_width_m` is 0
    level,     ///< a plane without end
    ground,    ///< the same, with the waves
    floor,     ///< a box that has a lower side, too, and waves on its top
    ramp       ///< a box without ends, with waves on its top, which rises from `height_m` to `height2_m`
  };
  Kind kind = Kind::level;
  Eigen::Vector2d from = Eigen::Vector2d::Zero();  ///< in the map [m]
  Eigen::Vector2d to = Eigen::Vector2d::Zero();
  double half_width_m = 0.0;
  double height_m = 0.0;                                            ///< of the top
  double base_m = 0.0;                                              ///< where it stands
  double height2_m = 0.0;                                           ///< of a ramp, at `to`
  std::shared_ptr<const std::vector<SurfaceWave>> waves = nullptr;  ///< null: none
};

/// Reads what the simulator writes as `surfaces_file`: kind,x_m,y_m,x2_m,y2_m,half_width_m,height_m, and
/// base_m,height2_m where the ground is not level; a row `wave` has k in x_m, y_m, the phase in x2_m and the amplitude
/// in height_m. Throws DataError with file and line.
std::vector<Surface> read_surfaces(const std::filesystem::path& file);

/// Distance [m] from a point to the surface, from inside as from outside. To ramps and waves it is taken along the
/// normal at the foot of the vertical: right where they are even for as far as the distance.
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
