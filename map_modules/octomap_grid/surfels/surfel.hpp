// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace waymark::octomap_grid {

/// The end points in one cell, summed up, and the plane through them. Lengths are relative to the cell's middle [m].
struct Surfel {
  /// A cell that holds so many takes no more: what came first is what later scans are matched to, so that the map does
  /// not drift while the robot stands.
  static constexpr std::uint32_t kEnough = 100;

  std::int32_t z = 0;  ///< of the cell, counted in cells
  std::uint32_t count = 0;
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  std::array<float, 6> products{};  ///< Σ of xx, xy, xz, yy, yz, zz

  // The plane follows from the sums.
  Eigen::Vector3f middle = Eigen::Vector3f::Zero();  ///< mean of the points
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  ///< of length 1; zero: the points do not lie in a plane
  float variance = 0.0f;                             ///< across the plane [m²]

  bool is_plane() const { return !normal.isZero(0.0f); }
  void add(const Eigen::Vector3f& p) {
    ++count;
    sum += p;
    products[0] += p.x() * p.x();
    products[1] += p.x() * p.y();
    products[2] += p.x() * p.z();
    products[3] += p.y() * p.y();
    products[4] += p.y() * p.z();
    products[5] += p.z() * p.z();
  }
  /// Adds what another one of the same cell holds.
  void add(const Surfel& other);
  /// Finds the plane anew. `cell`: side of the cell [m].
  void fit(float cell);
};

}  // namespace waymark::octomap_grid
