// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>

#include "layered_map.hpp"

namespace waymark::maps {

/// A box along the axes of the map's frame [m].
struct Box {
  double west;
  double south;
  double east;
  double north;
  double low = -std::numeric_limits<double>::infinity();  ///< of octrees
  double high = std::numeric_limits<double>::infinity();

  bool holds(const Eigen::Vector3d& p) const {
    return p.x() >= west && p.x() <= east && p.y() >= south && p.y() <= north && p.z() >= low && p.z() <= high;
  }
};

/// Leaves landmarks, cells and voxels whose middles lie in the box. A layer of which nothing is left is taken out.
/// Throws Error if nothing is left at all, or if a voxel of kilometres would have to be cut.
void crop(LayeredMap& map, const Box& box);

/// Adds the layers of another map. Layers of one name become one: of two landmarks that are closer than
/// `same_landmark_m` the one with the smaller covariance stays; a cell is occupied if it is in one of both; log-odds of
/// voxels are added. Cells and voxels move by up to half their side if the maps are placed differently. Throws Error if
/// the frames differ or a layer does not fit.
void merge(LayeredMap& map, const LayeredMap& other, double same_landmark_m);

/// Moves all layers.
void move(LayeredMap& map, const Pose& T_to_from);

/// Where the frame at one datum lies in that of another one: planar, with a height. Throws Error if they are more than
/// 10 km apart, since the Earth is round.
Pose between(const Datum& to, const Datum& from);

}  // namespace waymark::maps
