// SPDX-License-Identifier: Apache-2.0
#include "map_modules/octomap_grid/surfels/surfel.hpp"

#include <Eigen/Eigenvalues>

namespace waymark::octomap_grid {

void Surfel::add(const Surfel& other) {
  count += other.count;
  sum += other.sum;
  for (std::size_t i = 0; i < products.size(); ++i) products[i] += other.products[i];
}

void Surfel::fit(float cell) {
  constexpr std::uint32_t kLeast = 6;    // points of a plane
  constexpr double kWide = 0.1;          // of the cell: σ of the points along the plane, in both directions
  constexpr double kFlat = 0.05;         // of the variance along the plane: that across it
  constexpr double kLeastSigma = 0.005;  // across the plane [m]: no surface is better known
  normal.setZero();
  variance = 0.0f;
  if (count == 0) return;
  const double n = count;
  middle = (sum.cast<double>() / n).cast<float>();
  if (count < kLeast) return;
  const Eigen::Vector3d mean = sum.cast<double>() / n;
  Eigen::Matrix3d C;
  C << static_cast<double>(products[0]), static_cast<double>(products[1]), static_cast<double>(products[2]),
      static_cast<double>(products[1]), static_cast<double>(products[3]), static_cast<double>(products[4]),
      static_cast<double>(products[2]), static_cast<double>(products[4]), static_cast<double>(products[5]);
  C = (C / n - mean * mean.transpose()).eval();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
  eigen.computeDirect(C);
  const Eigen::Vector3d& values = eigen.eigenvalues();
  const double wide = kWide * static_cast<double>(cell);
  if (!(values[1] >= wide * wide) || !(values[0] <= kFlat * values[1])) return;
  normal = eigen.eigenvectors().col(0).cast<float>();
  variance = static_cast<float>(std::max(values[0], kLeastSigma * kLeastSigma));
}

}  // namespace waymark::octomap_grid
