// SPDX-License-Identifier: Apache-2.0
#include "sheet.hpp"

#include <algorithm>
#include <cmath>

#include "framing.hpp"

namespace waymark::plot {
namespace {

double unit_of(const Style& style) {
  return std::clamp(std::min(style.width_px / 1600.0, style.height_px / 1200.0), 0.5, 6.0);
}

/// The map's part of the picture: the axes' numbers are to the left and below, the legend to the right.
Rect map_area(const Content& content, const Style& style) {
  const double unit = unit_of(style);
  return {unit * (content.axes.origin.isZero() ? 78 : 112), unit * 72, style.width_px - unit * 330,
          style.height_px - unit * 58};
}

}  // namespace

Sheet::Sheet(const Content& drawn, const Style& how)
    : content(drawn),
      style(how),
      unit(unit_of(how)),
      canvas(how.width_px, how.height_px),
      view(make_view(drawn, how, map_area(drawn, how))) {}

Points arrow(const Eigen::Vector2d& at, double yaw, double length) {
  const Eigen::Vector2d ahead(std::cos(yaw), -std::sin(yaw));
  const Eigen::Vector2d aside(-ahead.y(), ahead.x());
  return {at + length * ahead, at - 0.7 * length * ahead + 0.65 * length * aside, at - 0.3 * length * ahead,
          at - 0.7 * length * ahead - 0.65 * length * aside};
}

}  // namespace waymark::plot
