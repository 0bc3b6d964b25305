// SPDX-License-Identifier: Apache-2.0
#include "loops/score_raster.hpp"

#include <algorithm>
#include <cmath>

namespace waymark::loops {

void ScoreRaster::draw(std::span<const Eigen::Vector2f> points, double sigma, int levels) {
  constexpr auto kCells = static_cast<std::size_t>(kSide) * kSide;
  std::vector<std::uint8_t>& fine = levels_[0];
  fine.assign(kCells, 0);
  const int reach = static_cast<int>(std::ceil(2.5 * sigma / kCell));
  const int width = 2 * reach + 1;
  std::vector<std::uint8_t> stamp;
  stamp.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(width));
  for (int y = -reach; y <= reach; ++y) {
    for (int x = -reach; x <= reach; ++x) {
      const double squared = kCell * kCell * (x * x + y * y);
      stamp.push_back(static_cast<std::uint8_t>(std::lround(255.0 * std::exp(-0.5 * squared / (sigma * sigma)))));
    }
  }
  for (const Eigen::Vector2f& p : points) {
    if (!(p.squaredNorm() < static_cast<float>(kReach * kReach))) continue;
    const int x = static_cast<int>(in_cells(static_cast<double>(p.x())));
    const int y = static_cast<int>(in_cells(static_cast<double>(p.y())));
    if (fine[static_cast<std::size_t>(y) * kSide + static_cast<std::size_t>(x)] == 255) continue;
    for (int row = 0; row < width; ++row) {
      std::uint8_t* to = fine.data() + static_cast<std::ptrdiff_t>(y - reach + row) * kSide + (x - reach);
      const std::uint8_t* from = stamp.data() + static_cast<std::ptrdiff_t>(row) * width;
      for (int column = 0; column < width; ++column) to[column] = std::max(to[column], from[column]);
    }
  }
  for (int level = 1; level < levels; ++level) {
    // The largest of four squares of the level below, which beyond the edge are empty.
    const std::vector<std::uint8_t>& below = levels_[static_cast<std::size_t>(level - 1)];
    std::vector<std::uint8_t>& above = levels_[static_cast<std::size_t>(level)];
    above = below;
    const int step = 1 << (level - 1);
    for (int y = 0; y < kSide; ++y) {
      std::uint8_t* to = above.data() + static_cast<std::ptrdiff_t>(y) * kSide;
      const std::uint8_t* near = below.data() + static_cast<std::ptrdiff_t>(y) * kSide;
      const std::uint8_t* far = y + step < kSide ? near + static_cast<std::ptrdiff_t>(step) * kSide : near;
      for (int x = 0; x < kSide - step; ++x)
        to[x] = std::max(std::max(near[x], near[x + step]), std::max(far[x], far[x + step]));
      for (int x = kSide - step; x < kSide; ++x) to[x] = std::max(near[x], far[x]);
    }
  }
}

}  // namespace waymark::loops
