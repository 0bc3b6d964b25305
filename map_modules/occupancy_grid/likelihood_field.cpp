// SPDX-License-Identifier: Apache-2.0
#include "likelihood_field.hpp"

#include <algorithm>
#include <cmath>

namespace waymark::grid {

namespace {

/// End points in cells of the window, as a function of the pose.
struct Projection {
  Projection(const TileWindow& window, const Eigen::Vector3d& xyyaw, double resolution)
      : c(static_cast<float>(std::cos(xyyaw.z()) / resolution)),
        s(static_cast<float>(std::sin(xyyaw.z()) / resolution)),
        x(static_cast<float>(xyyaw.x() / resolution - window.origin().x)),
        y(static_cast<float>(xyyaw.y() / resolution - window.origin().y)) {}
  float c;
  float s;
  float x;
  float y;
};

// More factors of 0.1 than this in one product come near the smallest double.
constexpr int kFactors = 128;

}  // namespace

LikelihoodTable::LikelihoodTable(double sigma, double resolution) {
  for (std::size_t i = 0; i < values_.size(); ++i) {
    const double cells = std::min(static_cast<double>(i) / Tile::kDistanceSteps, static_cast<double>(Tile::kReach));
    values_[i] = static_cast<float>(std::exp(-0.5 * std::pow(cells * resolution / sigma, 2)));
  }
}

FieldFit fit_points(const TileWindow& window, const LikelihoodTable& table, std::span<const Eigen::Vector2f> points,
                    const Eigen::Vector3d& xyyaw, double resolution) {
  FieldFit fit;
  const Projection at(window, xyyaw, resolution);
  const auto most_x = static_cast<float>(window.columns() - 1);
  const auto most_y = static_cast<float>(window.rows() - 1);
  double xx = 0.0, xy = 0.0, yy = 0.0, xt = 0.0, yt = 0.0, tt = 0.0, rx = 0.0, ry = 0.0, rt = 0.0, sum = 0.0;
  double product = 1.0;
  int factors = 0;
  for (const Eigen::Vector2f& p : points) {
    const float qx = at.c * p.x() - at.s * p.y();  // from the base, in cells
    const float qy = at.s * p.x() + at.c * p.y();
    const float u = qx + at.x - 0.5f;  // from the middle of the first cell
    const float v = qy + at.y - 0.5f;
    float l00 = 0.0f, l10 = 0.0f, l01 = 0.0f, l11 = 0.0f, fx = 0.0f, fy = 0.0f;
    if (u >= 0.0f && v >= 0.0f && u < most_x && v < most_y) {
      const int x = static_cast<int>(u);
      const int y = static_cast<int>(v);
      fx = u - static_cast<float>(x);
      fy = v - static_cast<float>(y);
      constexpr int kLast = Tile::kSide - 1;
      if ((x & kLast) != kLast && (y & kLast) != kLast) {
        const std::uint8_t* d = &window.tile(window.slot(x, y)).distance[Tile::place(x, y)];
        l00 = table[d[0]];
        l10 = table[d[1]];
        l01 = table[d[Tile::kSide]];
        l11 = table[d[Tile::kSide + 1]];
      } else {
        l00 = table[window.distance(x, y)];
        l10 = table[window.distance(x + 1, y)];
        l01 = table[window.distance(x, y + 1)];
        l11 = table[window.distance(x + 1, y + 1)];
      }
    }
    const float bottom = l00 + fx * (l10 - l00);
    const float top = l01 + fx * (l11 - l01);
    const float likelihood = bottom + fy * (top - bottom);
    const float gx = (l10 - l00) + fy * ((l11 - l01) - (l10 - l00));  // per cell
    const float gy = top - bottom;
    const float gt = gy * qx - gx * qy;
    const float rest = 1.0f - likelihood;
    sum += static_cast<double>(likelihood);
    xx += static_cast<double>(gx * gx);
    xy += static_cast<double>(gx * gy);
    yy += static_cast<double>(gy * gy);
    xt += static_cast<double>(gx * gt);
    yt += static_cast<double>(gy * gt);
    tt += static_cast<double>(gt * gt);
    rx += static_cast<double>(gx * rest);
    ry += static_cast<double>(gy * rest);
    rt += static_cast<double>(gt * rest);
    product *= 0.9 * static_cast<double>(likelihood) + 0.1;
    if (++factors == kFactors) {
      fit.log_likelihood += std::log(product);
      product = 1.0;
      factors = 0;
    }
  }
  fit.log_likelihood += std::log(product);
  fit.JtJ << xx, xy, xt, xy, yy, yt, xt, yt, tt;
  fit.Jtr << rx, ry, rt;
  const Eigen::Vector3d per_unit(1.0 / resolution, 1.0 / resolution, 1.0);
  fit.JtJ = per_unit.asDiagonal() * fit.JtJ * per_unit.asDiagonal();
  fit.Jtr = per_unit.asDiagonal() * fit.Jtr;
  fit.score = points.empty() ? 0.0 : sum / static_cast<double>(points.size());
  return fit;
}

double sum_likelihood(const TileWindow& window, const LikelihoodTable& table, std::span<const Eigen::Vector2f> points,
                      const Eigen::Vector3d& xyyaw, double resolution) {
  const Projection at(window, xyyaw, resolution);
  double sum = 0.0;
  for (const Eigen::Vector2f& p : points) {
    const float u = at.c * p.x() - at.s * p.y() + at.x;
    const float v = at.s * p.x() + at.c * p.y() + at.y;
    if (!(u >= 0.0f && v >= 0.0f)) continue;
    const int x = static_cast<int>(u);
    const int y = static_cast<int>(v);
    if (window.holds(x, y)) sum += static_cast<double>(table[window.distance(x, y)]);
  }
  return sum;
}

}  // namespace waymark::grid
