// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace waymark::loops {

/// Sums over points, at shifts by whole cells of −kShifts … kShifts along x and y.
template <int kShifts>
class ShiftedSums {
 public:
  static constexpr int kSide = 2 * kShifts + 1;
  static constexpr int kColumns = (kSide + 7) / 8 * 8;  ///< of a row, for vectors

  float at(int row, int column) const {
    return sums_[static_cast<std::size_t>(row) * kColumns + static_cast<std::size_t>(column)];
  }
  float* row(int row) { return sums_.data() + static_cast<std::ptrdiff_t>(row) * kColumns; }

 private:
  std::array<float, static_cast<std::size_t>(kSide) * kColumns> sums_{};
};

/// How well a point fits the surfaces of a window, as a picture: exp(−d²/(2σ²)) of the distance d to the nearest of
/// its points, 0 … 255. Level h holds the largest value of 2^h × 2^h cells from a cell on, a bound for the search
/// (W. Hess et al., ICRA 2016).
class ScoreRaster {
 public:
  static constexpr double kCell = 0.1;  ///< [m]
  static constexpr int kLevels = 6;     ///< the coarsest one spans 3.2 m

  /// `reach`: points farther from the middle are left out [m].
  explicit ScoreRaster(double reach)
      : reach_(reach), side_(2 * static_cast<int>(reach / kCell) + 4 * (1 << (kLevels - 1))) {}

  /// Draws `points` [m]. `levels`: how many are needed.
  void draw(std::span<const Eigen::Vector2f> points, double sigma, int levels);

  /// The value of a cell; 0 outside.
  std::uint8_t at(int level, int x, int y) const {
    if (static_cast<unsigned>(x) >= static_cast<unsigned>(side_) ||
        static_cast<unsigned>(y) >= static_cast<unsigned>(side_))
      return 0;
    return levels_[static_cast<std::size_t>(level)]
                  [static_cast<std::size_t>(y) * static_cast<std::size_t>(side_) + static_cast<std::size_t>(x)];
  }
  /// Adds the values about x, y [cells] at whole shifts, bilinear between the middles of cells, 0 … 255 each.
  template <int kShifts>
  void add_shifted(float x, float y, ShiftedSums<kShifts>& sums) const;
  /// A position [m] in cells.
  float in_cells(double p) const { return static_cast<float>(p / kCell + 0.5 * side_); }

 private:
  double reach_;
  // The middle is cell side_ / 2. A point at the edge of a search still has cells of the coarsest level around it.
  int side_;
  std::array<std::vector<std::uint8_t>, kLevels> levels_;
};

template <int kShifts>
void ScoreRaster::add_shifted(float x, float y, ShiftedSums<kShifts>& sums) const {
  const float u = std::floor(x - 0.5f);
  const float v = std::floor(y - 0.5f);
  const int i = static_cast<int>(u) - kShifts;
  const int j = static_cast<int>(v) - kShifts;
  // Shifts near the edge are beyond all points.
  if (i < 0 || j < 0 || i + sums.kColumns >= side_ || j + sums.kSide >= side_) return;
  const float fx = x - 0.5f - u;
  const float fy = y - 0.5f - v;
  const float w00 = (1.0f - fx) * (1.0f - fy);
  const float w10 = fx * (1.0f - fy);
  const float w01 = (1.0f - fx) * fy;
  const float w11 = fx * fy;
  const std::uint8_t* low = levels_[0].data() + static_cast<std::ptrdiff_t>(j) * side_ + i;
  for (int row = 0; row < sums.kSide; ++row, low += side_) {
    const std::uint8_t* const high = low + side_;
    float* const to = sums.row(row);
    for (int k = 0; k < sums.kColumns; ++k)
      to[k] += w00 * low[k] + w10 * low[k + 1] + w01 * high[k] + w11 * high[k + 1];
  }
}

}  // namespace waymark::loops
