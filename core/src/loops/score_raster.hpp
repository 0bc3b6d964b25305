// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace waymark::loops {

/// How well a point fits the surfaces of a window, as a picture: exp(−d²/(2σ²)) of the distance d to the nearest of
/// its points, 0 … 255. Level h holds the largest value of 2^h × 2^h cells from a cell on, a bound for the search
/// (W. Hess et al., ICRA 2016).
class ScoreRaster {
 public:
  static constexpr double kCell = 0.1;  ///< [m]
  static constexpr int kLevels = 6;     ///< the coarsest one spans 3.2 m
  static constexpr double kReach = 30;  ///< points farther from the middle are left out [m]

  /// Draws `points` [m]. `levels`: how many are needed.
  void draw(std::span<const Eigen::Vector2f> points, double sigma, int levels);

  /// The value of a cell; 0 outside.
  std::uint8_t at(int level, int x, int y) const {
    if (static_cast<unsigned>(x) >= static_cast<unsigned>(kSide) ||
        static_cast<unsigned>(y) >= static_cast<unsigned>(kSide))
      return 0;
    return levels_[static_cast<std::size_t>(level)][static_cast<std::size_t>(y) * kSide + static_cast<std::size_t>(x)];
  }
  /// Bilinear between the middles of cells, 0 … 255; x, y in cells.
  float between(float x, float y) const;
  /// A position [m] in cells.
  static float in_cells(double p) { return static_cast<float>(p / kCell + kSide / 2); }

 private:
  // The middle is cell kSide / 2. A point at the edge of a search still has cells of the coarsest level around it.
  static constexpr int kSide = 2 * static_cast<int>(kReach / kCell) + 4 * (1 << (kLevels - 1));

  std::array<std::vector<std::uint8_t>, kLevels> levels_;
};

}  // namespace waymark::loops
