// SPDX-License-Identifier: Apache-2.0
#include "framing.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace waymark::plot {
namespace {

using Points = std::vector<Eigen::Vector2d>;

class Extent {
 public:
  void add(const Eigen::Vector2d& p) {
    if (!p.allFinite()) return;
    low_ = low_.cwiseMin(p);
    high_ = high_.cwiseMax(p);
  }
  // Without the outermost hundredth: one wild fix must not shrink the map to a dot.
  void add_most(const Points& points) {
    if (points.empty()) return;
    for (const int axis : {0, 1}) {
      std::vector<double> v;
      for (const Eigen::Vector2d& p : points) v.push_back(p[axis]);
      std::sort(v.begin(), v.end());
      const std::size_t cut = v.size() / 100;
      low_[axis] = std::min(low_[axis], v[cut]);
      high_[axis] = std::max(high_[axis], v[v.size() - 1 - cut]);
    }
  }
  bool empty() const { return !(low_.x() <= high_.x()); }
  Eigen::Vector2d low() const { return low_; }
  Eigen::Vector2d high() const { return high_; }

 private:
  Eigen::Vector2d low_ = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d high_ = -low_;
};

}  // namespace

double round_step(double least) {
  const double power = std::pow(10.0, std::floor(std::log10(least)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= least * (1.0 - 1e-9)) return factor * power;
  }
  return 10.0 * power;
}

View make_view(const Content& content, const Style& style, const Rect& area) {
  if (style.window) return View(area, style.window->low, style.window->high);
  Extent extent;
  for (const auto& p : content.online) extent.add(p);
  if (content.reference != nullptr) {
    for (const auto& point : content.reference->trajectory) extent.add(planar(point.T_map_base));
    for (const auto& landmark : content.reference->landmarks) extent.add(landmark.p_map);
  }
  if (content.end) {
    extent.add(planar(content.end->T_map_base));
    for (const auto& node : content.end->best_path) extent.add(planar(node.T_map_base));
    for (const auto& map : content.end->maps) {
      for (const auto& landmark : map.landmarks) extent.add(landmark.p_map);
      if (!map.grid) continue;
      for (const int x : {0, map.grid->width}) {
        for (const int y : {0, map.grid->height}) {
          const Eigen::Vector3d corner(x * map.grid->resolution_m, y * map.grid->resolution_m, 0.0);
          extent.add(planar({map.grid->T_map_grid.q, map.grid->T_map_grid * corner}));
        }
      }
    }
  }
  extent.add_most(content.gnss_fused);
  extent.add_most(content.gnss_rejected);
  extent.add_most(content.gnss_held_out);
  if (extent.empty()) return View(area, {-10.0, -10.0}, {10.0, 10.0});
  const double margin = std::max(1.0, 0.05 * (extent.high() - extent.low()).maxCoeff());
  return View(area, extent.low().array() - margin, extent.high().array() + margin);
}

}  // namespace waymark::plot
