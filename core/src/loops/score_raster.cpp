// SPDX-License-Identifier: Apache-2.0
#include "loops/score_raster.hpp"

#include <algorithm>
#include <cmath>

namespace waymark::loops {

namespace {

/// The values around a point, for places of it within its cell: a wall along the axes would else be wrong by up to half
/// a cell in all its points alike.
class Stamps {
 public:
  explicit Stamps(double sigma) : reach_(static_cast<int>(std::ceil(2.5 * sigma / ScoreRaster::kCell))) {
    for (int sub_y = 0; sub_y < kParts; ++sub_y) {
      for (int sub_x = 0; sub_x < kParts; ++sub_x) add(middle(sub_x), middle(sub_y), sigma);
    }
  }
  int reach() const { return reach_; }
  /// Row by row; `u`, `v` from 0 to 1.
  const std::uint8_t* at(float u, float v) const {
    const auto part = [](float x) { return std::clamp(static_cast<int>(x * kParts), 0, kParts - 1); };
    const int width = 2 * reach_ + 1;
    return values_.data() + static_cast<std::ptrdiff_t>(part(v) * kParts + part(u)) * width * width;
  }

 private:
  static constexpr int kParts = 4;
  static double middle(int part) { return (part + 0.5) / kParts - 0.5; }
  void add(double x, double y, double sigma) {
    for (int row = -reach_; row <= reach_; ++row) {
      for (int column = -reach_; column <= reach_; ++column) {
        const double d = ScoreRaster::kCell * std::hypot(column - x, row - y);
        values_.push_back(static_cast<std::uint8_t>(std::lround(255.0 * std::exp(-0.5 * d * d / (sigma * sigma)))));
      }
    }
  }

  int reach_;
  std::vector<std::uint8_t> values_;
};

}  // namespace

void ScoreRaster::draw(std::span<const Eigen::Vector2f> points, double sigma, int levels) {
  const auto cells = static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_);
  std::vector<std::uint8_t>& fine = levels_[0];
  fine.assign(cells, 0);
  const Stamps stamps(sigma);
  const int reach = stamps.reach();
  const int width = 2 * reach + 1;
  for (const Eigen::Vector2f& p : points) {
    if (!(p.squaredNorm() < static_cast<float>(reach_ * reach_))) continue;
    const float u = in_cells(static_cast<double>(p.x()));
    const float v = in_cells(static_cast<double>(p.y()));
    const int x = static_cast<int>(u);
    const int y = static_cast<int>(v);
    const std::uint8_t* from = stamps.at(u - static_cast<float>(x), v - static_cast<float>(y));
    for (int row = 0; row < width; ++row) {
      std::uint8_t* to = fine.data() + static_cast<std::ptrdiff_t>(y - reach + row) * side_ + (x - reach);
      for (int column = 0; column < width; ++column) to[column] = std::max(to[column], from[column]);
      from += width;
    }
  }
  for (int level = 1; level < levels; ++level) {
    // The largest of four squares of the level below, which beyond the edge are empty.
    const std::vector<std::uint8_t>& below = levels_[static_cast<std::size_t>(level - 1)];
    std::vector<std::uint8_t>& above = levels_[static_cast<std::size_t>(level)];
    above = below;
    const int step = 1 << (level - 1);
    for (int y = 0; y < side_; ++y) {
      std::uint8_t* to = above.data() + static_cast<std::ptrdiff_t>(y) * side_;
      const std::uint8_t* near = below.data() + static_cast<std::ptrdiff_t>(y) * side_;
      const std::uint8_t* far = y + step < side_ ? near + static_cast<std::ptrdiff_t>(step) * side_ : near;
      for (int x = 0; x < side_ - step; ++x)
        to[x] = std::max(std::max(near[x], near[x + step]), std::max(far[x], far[x + step]));
      for (int x = side_ - step; x < side_; ++x) to[x] = std::max(near[x], far[x]);
    }
  }
}

}  // namespace waymark::loops
