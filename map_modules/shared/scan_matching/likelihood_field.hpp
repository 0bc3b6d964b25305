// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
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
  double score = 0.0;                             ///< mean of L where the map is known; 0 if that is nowhere
  double unknown = 0.0;                           ///< share of the points where it is not: they only count as below
  double log_likelihood = 0.0;                    ///< Σ log(0.9 L + 0.1), with L = 0 where the map is unknown
};

/// What a fit is summed up from, in cells; of one field or of several.
struct FieldSums {
  double xx = 0.0, xy = 0.0, yy = 0.0, xt = 0.0, yt = 0.0, tt = 0.0, rx = 0.0, ry = 0.0, rt = 0.0, sum = 0.0;
  double product = 1.0;  // of the last points, whose logarithm is still to be added
  double log_likelihood = 0.0;
  int blocks = 0;  // in `product`
  std::size_t points = 0;
  std::size_t unknown = 0;  // of the points, those that end where the map is unknown

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

/// L of some end points over one field, and its derivatives, computed side by side.
class PointBlock {
 public:
  static constexpr int kPoints = 16;
  using Values = Eigen::Array<float, kPoints, 1>;

  /// Places the next point: `qx`, `qy` from the base in cells; L of the four cells about it, and where it lies between.
  void place(float qx, float qy, float l00, float l10, float l01, float l11, float fx, float fy) {
    qx_[size_] = qx;
    qy_[size_] = qy;
    l00_[size_] = l00;
    l10_[size_] = l10;
    l01_[size_] = l01;
    l11_[size_] = l11;
    fx_[size_] = fx;
    fy_[size_] = fy;
    ++size_;
  }
  bool is_full() const { return size_ == kPoints; }
  /// Adds the points and forgets them.
  void add_to(FieldSums& sums);

 private:
  Eigen::Index size_ = 0;
  Values qx_ = Values::Zero(), qy_ = Values::Zero(), fx_ = Values::Zero(), fy_ = Values::Zero();
  Values l00_ = Values::Zero(), l10_ = Values::Zero(), l01_ = Values::Zero(), l11_ = Values::Zero();
};

/// Whether the map is known just before a beam ends at (u, v): as far before as distances are kept, and there in
/// the cells beside that half the space between two beams takes in, since far off that is unknown in every map. Not
/// inlined: few points are asked for, in the innermost loop. All in cells.
template <class Field>
[[gnu::noinline]] bool is_known_before(const Field& field, float u, float v, float qx, float qy) {
  constexpr auto kBefore = static_cast<float>(StoredDistance::kReach);
  constexpr float kHalfBetween = 0.0087f;  // half a degree
  const auto is_known = [&](float x, float y) {
    if (!(x >= 0.0f && y >= 0.0f)) return false;
    const int column = static_cast<int>(x);
    const int row = static_cast<int>(y);
    return field.holds(column, row) && field.is_known(column, row);
  };
  const float length = std::sqrt(qx * qx + qy * qy);
  if (length <= 0.0f) return false;
  const float dx = qx / length;
  const float dy = qy / length;
  const float before = std::min(length, kBefore);
  const float x = u - before * dx;
  const float y = v - before * dy;
  if (is_known(x, y)) return true;
  const float most = std::floor(kHalfBetween * length);
  for (float beside = 1.0f; beside <= most; ++beside) {
    if (is_known(x - beside * dy, y + beside * dx) || is_known(x + beside * dy, y - beside * dx)) return true;
  }
  return false;
}

/// Whether the map is known where a beam ends: at its end (u, v), which is in the field, or just before, since what a
/// beam ends behind is often known alone. `qx`, `qy` is the end from the base. All in cells.
///
/// Where it is not known the beam shows a part of the world for the first time. The nearest occupied cell is then where
/// the known part ends, and would pull the scan towards what has been seen before: less far, and less of a turn.
template <class Field>
bool ends_in_known(const Field& field, float u, float v, float qx, float qy) {
  const int x = static_cast<int>(u);
  const int y = static_cast<int>(v);
  // What is occupied is known; that costs less.
  return field.distance(x, y) == 0 || field.is_known(x, y) || is_known_before(field, u, v, qx, qy);
}

/// Adds L of end points with the base at `xyyaw`, bilinear between the middles of four cells. Those that end where the
/// map is unknown are only counted; L is 0 outside of the field.
///
/// A field is made of squares of `kSide` × `kSide` cells (a power of two): it has `origin()`, the map's cell that is
/// (0, 0) in it, `columns()`, `rows()`, `distance(x, y)`, `distances_at(x, y)`, where that is stored, followed by those
/// of the cells to the right in its square, `is_known(x, y)` and `holds(x, y)`.
template <class Field>
FieldSums add_points(FieldSums sums, const Field& field, const LikelihoodTable& table,
                     std::span<const Eigen::Vector2f> points, const Eigen::Vector3d& xyyaw, double resolution) {
  constexpr int kLast = Field::kSide - 1;
  const FieldProjection at(field.origin(), xyyaw, resolution);
  const auto most_x = static_cast<float>(field.columns() - 1);
  const auto most_y = static_cast<float>(field.rows() - 1);
  PointBlock block;
  for (const Eigen::Vector2f& p : points) {
    const float qx = at.c * p.x() - at.s * p.y();  // from the base, in cells
    const float qy = at.s * p.x() + at.c * p.y();
    const float u = qx + at.x - 0.5f;  // from the middle of the first cell
    const float v = qy + at.y - 0.5f;
    float l00 = 0.0f, l10 = 0.0f, l01 = 0.0f, l11 = 0.0f, fx = 0.0f, fy = 0.0f;
    if (u >= 0.0f && v >= 0.0f && u < most_x && v < most_y) {
      const int x = static_cast<int>(u);
      const int y = static_cast<int>(v);
      if (!ends_in_known(field, u + 0.5f, v + 0.5f, qx, qy)) {
        ++sums.unknown;
        continue;
      }
      fx = u - static_cast<float>(x);
      fy = v - static_cast<float>(y);
      if ((x & kLast) != kLast) {
        const std::uint8_t* lower = field.distances_at(x, y);
        const std::uint8_t* upper = field.distances_at(x, y + 1);
        l00 = table[lower[0]];
        l10 = table[lower[1]];
        l01 = table[upper[0]];
        l11 = table[upper[1]];
      } else {
        l00 = table[field.distance(x, y)];
        l10 = table[field.distance(x + 1, y)];
        l01 = table[field.distance(x, y + 1)];
        l11 = table[field.distance(x + 1, y + 1)];
      }
    }
    block.place(qx, qy, l00, l10, l01, l11, fx, fy);
    if (block.is_full()) block.add_to(sums);
  }
  block.add_to(sums);
  sums.points += points.size();
  return sums;
}

template <class Field>
FieldFit fit_points(const Field& field, const LikelihoodTable& table, std::span<const Eigen::Vector2f> points,
                    const Eigen::Vector3d& xyyaw, double resolution) {
  return add_points({}, field, table, points, xyyaw, resolution).fit(resolution);
}

/// Σ L without interpolation or derivatives, for searches. Where it cannot reach `least`, part of the sum.
template <class Field>
double sum_likelihood(const Field& field, const LikelihoodTable& table, std::span<const Eigen::Vector2f> points,
                      const Eigen::Vector3d& xyyaw, double resolution, double least) {
  constexpr std::size_t kBetween = 16;  // points between two looks at what can still be reached
  const FieldProjection at(field.origin(), xyyaw, resolution);
  double sum = 0.0;
  for (std::size_t first = 0; first < points.size(); first += kBetween) {
    // L is at most 1.
    if (sum + static_cast<double>(points.size() - first) < least) return sum;
    for (const Eigen::Vector2f& p : points.subspan(first, std::min(kBetween, points.size() - first))) {
      const float u = at.c * p.x() - at.s * p.y() + at.x;
      const float v = at.s * p.x() + at.c * p.y() + at.y;
      if (!(u >= 0.0f && v >= 0.0f)) continue;
      const int x = static_cast<int>(u);
      const int y = static_cast<int>(v);
      if (field.holds(x, y)) sum += static_cast<double>(table[field.distance(x, y)]);
    }
  }
  return sum;
}

/// Whether the way from `from` to `to` [cells] leads through something occupied. Where nothing is near the steps are as
/// long as that is far; the last ones before the end are not looked at, since the end may be a surface.
template <class Field>
bool is_blocked(const Field& field, const Eigen::Vector2f& from, const Eigen::Vector2f& to) {
  const float length = (to - from).norm();
  for (float way = 0.0f; way < length - StoredDistance::kReach;) {
    const Eigen::Vector2f at = from + (way / length) * (to - from);
    const int x = static_cast<int>(at.x());
    const int y = static_cast<int>(at.y());
    if (!field.holds(x, y)) return false;
    const int distance = field.distance(x, y);
    if (distance == 0) return true;
    way += static_cast<float>(std::clamp(distance / StoredDistance::kSteps, 1, StoredDistance::kReach));
  }
  return false;
}

/// Which end points are looked at.
enum class Ends { anywhere, in_unknown };

/// How many of the points lie behind something that is occupied: no beam gets there.
template <class Field>
std::size_t count_blocked(const Field& field, std::span<const Eigen::Vector2f> points, const Eigen::Vector3d& xyyaw,
                          double resolution, Ends ends) {
  const FieldProjection at(field.origin(), xyyaw, resolution);
  const Eigen::Vector2f base(at.x, at.y);
  std::size_t blocked = 0;
  for (const Eigen::Vector2f& p : points) {
    const Eigen::Vector2f q(at.c * p.x() - at.s * p.y(), at.s * p.x() + at.c * p.y());
    const Eigen::Vector2f end = base + q;
    if (!(end.minCoeff() >= 0.0f) || !field.holds(static_cast<int>(end.x()), static_cast<int>(end.y()))) continue;
    if (ends == Ends::in_unknown && ends_in_known(field, end.x(), end.y(), q.x(), q.y())) continue;
    blocked += is_blocked(field, base, end);
  }
  return blocked;
}

}  // namespace waymark::scan_matching
