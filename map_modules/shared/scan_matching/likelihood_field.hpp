// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include "map_modules/shared/scan_matching/cell.hpp"
#include "map_modules/shared/scan_matching/distance_field.hpp"

namespace waymark::scan_matching {

/// L = exp(−d²/(2σ²)) for every stored distance d (S. Thrun, W. Burgard, D. Fox, *Probabilistic Robotics*, 2005, §6.4).
/// One stored distance serves any number of widths.
class LikelihoodTable {
 public:
  LikelihoodTable(double sigma, double resolution);
  float operator[](std::uint8_t distance) const { return values_[distance]; }

 private:
  std::array<float, 256> values_;
};

/// How well end points fit a map, at one pose, and how that changes with (x [m], y [m], yaw [rad]).
struct FieldFit {
  Eigen::Matrix3d JtJ = Eigen::Matrix3d::Zero();  ///< Σ ∇L ∇Lᵀ
  Eigen::Vector3d Jtr = Eigen::Vector3d::Zero();  ///< Σ ∇L (1 − L): half the descent of Σ (1 − L)²
  double score = 0.0;                             ///< mean of L
  double log_likelihood = 0.0;                    ///< Σ log(0.9 L + 0.1)
};

/// What a fit is summed up from, in cells; of one field or of several.
struct FieldSums {
  double xx = 0.0, xy = 0.0, yy = 0.0, xt = 0.0, yt = 0.0, tt = 0.0, rx = 0.0, ry = 0.0, rt = 0.0, sum = 0.0;
  double product = 1.0;
  double log_likelihood = 0.0;
  int factors = 0;
  std::size_t points = 0;

  FieldFit fit(double resolution) const;
};

/// End points in cells of a field, as a function of the pose.
struct FieldProjection {
  FieldProjection(Cell origin, const Eigen::Vector3d& xyyaw, double resolution)
      : c(static_cast<float>(std::cos(xyyaw.z()) / resolution)),
        s(static_cast<float>(std::sin(xyyaw.z()) / resolution)),
        x(static_cast<float>(xyyaw.x() / resolution - origin.x)),
        y(static_cast<float>(xyyaw.y() / resolution - origin.y)) {}
  float c;
  float s;
  float x;
  float y;
};

/// Adds L of end points with the base at `xyyaw`, bilinear between the middles of four cells; 0 outside of the field.
///
/// A field is made of squares of `kSide` × `kSide` cells (a power of two): it has `origin()`, the map's cell that is
/// (0, 0) in it, `columns()`, `rows()`, `slot(x, y)`, which square a cell is in, `distances(slot)`, the stored
/// distances of that square row by row, `distance(x, y)` and `holds(x, y)`.
template <class Field>
FieldSums add_points(FieldSums sums, const Field& field, const LikelihoodTable& table,
                     std::span<const Eigen::Vector2f> points, const Eigen::Vector3d& xyyaw, double resolution) {
  // More factors of 0.1 than this in one product come near the smallest double.
  constexpr int kFactors = 128;
  constexpr int kLast = Field::kSide - 1;
  const FieldProjection at(field.origin(), xyyaw, resolution);
  const auto most_x = static_cast<float>(field.columns() - 1);
  const auto most_y = static_cast<float>(field.rows() - 1);
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
      if ((x & kLast) != kLast && (y & kLast) != kLast) {
        const std::uint8_t* d = field.distances(field.slot(x, y)) + (y & kLast) * Field::kSide + (x & kLast);
        l00 = table[d[0]];
        l10 = table[d[1]];
        l01 = table[d[Field::kSide]];
        l11 = table[d[Field::kSide + 1]];
      } else {
        l00 = table[field.distance(x, y)];
        l10 = table[field.distance(x + 1, y)];
        l01 = table[field.distance(x, y + 1)];
        l11 = table[field.distance(x + 1, y + 1)];
      }
    }
    const float bottom = l00 + fx * (l10 - l00);
    const float top = l01 + fx * (l11 - l01);
    const float likelihood = bottom + fy * (top - bottom);
    const float gx = (l10 - l00) + fy * ((l11 - l01) - (l10 - l00));  // per cell
    const float gy = top - bottom;
    const float gt = gy * qx - gx * qy;
    const float rest = 1.0f - likelihood;
    sums.sum += static_cast<double>(likelihood);
    sums.xx += static_cast<double>(gx * gx);
    sums.xy += static_cast<double>(gx * gy);
    sums.yy += static_cast<double>(gy * gy);
    sums.xt += static_cast<double>(gx * gt);
    sums.yt += static_cast<double>(gy * gt);
    sums.tt += static_cast<double>(gt * gt);
    sums.rx += static_cast<double>(gx * rest);
    sums.ry += static_cast<double>(gy * rest);
    sums.rt += static_cast<double>(gt * rest);
    sums.product *= 0.9 * static_cast<double>(likelihood) + 0.1;
    if (++sums.factors == kFactors) {
      sums.log_likelihood += std::log(sums.product);
      sums.product = 1.0;
      sums.factors = 0;
    }
  }
  sums.points += points.size();
  return sums;
}

template <class Field>
FieldFit fit_points(const Field& field, const LikelihoodTable& table, std::span<const Eigen::Vector2f> points,
                    const Eigen::Vector3d& xyyaw, double resolution) {
  return add_points({}, field, table, points, xyyaw, resolution).fit(resolution);
}

/// Σ L without interpolation or derivatives, for the coarse search.
template <class Field>
double sum_likelihood(const Field& field, const LikelihoodTable& table, std::span<const Eigen::Vector2f> points,
                      const Eigen::Vector3d& xyyaw, double resolution) {
  const FieldProjection at(field.origin(), xyyaw, resolution);
  double sum = 0.0;
  for (const Eigen::Vector2f& p : points) {
    const float u = at.c * p.x() - at.s * p.y() + at.x;
    const float v = at.s * p.x() + at.c * p.y() + at.y;
    if (!(u >= 0.0f && v >= 0.0f)) continue;
    const int x = static_cast<int>(u);
    const int y = static_cast<int>(v);
    if (field.holds(x, y)) sum += static_cast<double>(table[field.distance(x, y)]);
  }
  return sum;
}

/// Share of end points in unknown cells with nothing occupied near; 0 of a field without `is_known(x, y)`.
template <class Field>
double unknown_share(const Field& field, std::span<const Eigen::Vector2f> points, const Eigen::Vector3d& xyyaw,
                     double resolution) {
  std::size_t unknown = 0;
  if constexpr (requires { field.is_known(0, 0); }) {
    const FieldProjection at(field.origin(), xyyaw, resolution);
    for (const Eigen::Vector2f& p : points) {
      const float u = at.c * p.x() - at.s * p.y() + at.x;
      const float v = at.s * p.x() + at.c * p.y() + at.y;
      const int x = static_cast<int>(u);
      const int y = static_cast<int>(v);
      const bool is_inside = u >= 0.0f && v >= 0.0f && field.holds(x, y);
      unknown += !is_inside || (!field.is_known(x, y) && field.distance(x, y) == StoredDistance::kFar);
    }
  }
  return points.empty() ? 0.0 : static_cast<double>(unknown) / static_cast<double>(points.size());
}

}  // namespace waymark::scan_matching
