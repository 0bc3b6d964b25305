// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/evaluation/surfaces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <string_view>

#include "apps/waymark/evaluation/table.hpp"
#include "waymark/base/error.hpp"

namespace waymark::evaluation {

namespace {

constexpr std::array<std::string_view, 9> kColumns{"kind",         "x_m",      "y_m",    "x2_m",     "y2_m",
                                                   "half_width_m", "height_m", "base_m", "height2_m"};
enum Column { kKind, kX, kY, kX2, kY2, kHalfWidth, kHeight, kBase, kHeight2 };
constexpr int kColumnsOfLevelWorld = 7;
using Waves = std::vector<SurfaceWave>;

Surface::Kind kind_of_row(const Table& table, std::size_t row) {
  const std::string& kind = table.field(row, kKind);
  if (kind == "cylinder") return Surface::Kind::cylinder;
  if (kind == "box" || kind == "wall") return Surface::Kind::box;
  if (kind == "level") return Surface::Kind::level;
  if (kind == "ground") return Surface::Kind::ground;
  if (kind == "floor") return Surface::Kind::floor;
  if (kind == "ramp") return Surface::Kind::ramp;
  throw DataError(fmt::format("{}: kind is \"{}\"; cylinder, box, wall, level, ground, floor, ramp or wave is expected",
                              table.place(row), kind));
}

/// Half the length, and the direction of a box; of a cylinder no length.
struct Plan {
  Eigen::Vector2d middle;
  Eigen::Vector2d along;
  double half_length;

  explicit Plan(const Surface& s)
      : middle(0.5 * (s.from + s.to)), along(s.to - s.from), half_length(0.5 * along.norm()) {
    along /= 2.0 * half_length;
  }
  Eigen::Vector2d across() const { return {-along.y(), along.x()}; }
};

bool is_endless(const Surface& s) { return s.kind == Surface::Kind::level || s.kind == Surface::Kind::ground; }

/// Height of the top at a place, and its slope.
struct Top {
  double z;
  double slope;
};

Top top_at(const Surface& s, const Eigen::Vector2d& p) {
  double z = s.height_m;
  Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
  if (s.kind == Surface::Kind::ramp) {
    const Eigen::Vector2d span = s.to - s.from;
    const double rise = s.height2_m - s.height_m;
    z += rise * std::clamp((p - s.from).dot(span) / span.squaredNorm(), 0.0, 1.0);
    gradient = rise / span.squaredNorm() * span;
  }
  if (s.waves) {
    for (const SurfaceWave& wave : *s.waves) {
      const double angle = wave.k.dot(p) + wave.phase_rad;
      z += wave.amplitude_m * std::sin(angle);
      gradient += wave.amplitude_m * std::cos(angle) * wave.k;
    }
  }
  return {z, gradient.norm()};
}

/// Distance in the plane to the outline, negative inside.
double beside(const Surface& s, const Eigen::Vector2d& p) {
  if (s.kind == Surface::Kind::cylinder) return (p - s.from).norm() - s.half_width_m;
  const Plan plan(s);
  const Eigen::Vector2d v = p - plan.middle;
  const Eigen::Vector2d out(std::abs(v.dot(plan.along)) - plan.half_length,
                            std::abs(v.dot(plan.across())) - s.half_width_m);
  return out.maxCoeff() > 0.0 ? out.cwiseMax(0.0).norm() : out.maxCoeff();
}

/// Middles of the pieces, at most `spacing` long, of a stretch from `low` to `high`.
template <class Visit>
void for_pieces(double low, double high, double spacing, const Visit& visit) {
  const auto count = static_cast<int>(std::ceil((high - low) / spacing - 1e-9));
  for (int i = 0; i < count; ++i) visit(low + (high - low) * (i + 0.5) / count);
}

template <class Visit>
void for_outline(const Surface& s, double spacing, const Visit& visit) {
  if (s.kind == Surface::Kind::cylinder) {
    for_pieces(0.0, 2.0 * std::numbers::pi * s.half_width_m, spacing, [&](double arc) {
      const double angle = arc / s.half_width_m;
      visit(s.from + s.half_width_m * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    });
    return;
  }
  const Plan plan(s);
  const Eigen::Vector2d side = s.half_width_m * plan.across();
  for_pieces(-plan.half_length, plan.half_length, spacing, [&](double at) {
    visit(plan.middle + at * plan.along + side);
    if (s.half_width_m > 0.0) visit(plan.middle + at * plan.along - side);
  });
  if (s.kind == Surface::Kind::ramp) return;
  for_pieces(-s.half_width_m, s.half_width_m, spacing, [&](double at) {
    visit(s.from + at * plan.across());
    visit(s.to + at * plan.across());
  });
}

template <class Visit>
void for_top(const Surface& s, const Region& region, double spacing, const Visit& visit) {
  const bool is_level = is_endless(s);
  if (!is_level && s.kind != Surface::Kind::cylinder) {
    const Plan plan(s);
    for_pieces(-plan.half_length, plan.half_length, spacing, [&](double at) {
      for_pieces(-s.half_width_m, s.half_width_m, spacing,
                 [&](double aside) { visit(plan.middle + at * plan.along + aside * plan.across()); });
    });
    return;
  }
  const Eigen::Vector2d reach = Eigen::Vector2d::Constant(s.half_width_m);
  const Eigen::Vector2d low = is_level ? Eigen::Vector2d(region.low.head<2>()) : Eigen::Vector2d(s.from - reach);
  const Eigen::Vector2d high = is_level ? Eigen::Vector2d(region.high.head<2>()) : Eigen::Vector2d(s.from + reach);
  for_pieces(low.x(), high.x(), spacing, [&](double x) {
    for_pieces(low.y(), high.y(), spacing, [&](double y) {
      const Eigen::Vector2d p(x, y);
      if (is_level || beside(s, p) < 0.0) visit(p);
    });
  });
}

}  // namespace

std::vector<Surface> read_surfaces(const std::filesystem::path& file) {
  Table table(file);
  const bool has_base = table.width() != kColumnsOfLevelWorld;
  for (std::size_t i = 0; i < kColumns.size(); ++i) {
    const int column = static_cast<int>(i);
    if (!has_base && column == kColumnsOfLevelWorld) break;
    const bool fits = table.width() == static_cast<int>(kColumns.size()) || table.width() == kColumnsOfLevelWorld;
    if (fits && table.field(0, column) == kColumns[i]) continue;
    throw DataError(
        fmt::format("{}: the first row must be kind,x_m,y_m,x2_m,y2_m,half_width_m,height_m", table.place(0)));
  }
  table.drop_first_row();
  std::vector<Surface> surfaces;
  surfaces.reserve(table.rows());
  const auto waves = std::make_shared<Waves>();
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const auto number = [&](Column column) { return table.number(row, column, kColumns[column]); };
    if (table.field(row, kKind) == "wave") {
      waves->push_back({{number(kX), number(kY)}, number(kX2), number(kHeight)});
      continue;
    }
    Surface s;
    s.kind = kind_of_row(table, row);
    s.height_m = s.height2_m = number(kHeight);
    if (!is_endless(s)) {
      s.from = s.to = {number(kX), number(kY)};
      s.half_width_m = number(kHalfWidth);
      if (s.kind != Surface::Kind::cylinder) s.to = {number(kX2), number(kY2)};
      if (has_base) s.base_m = number(kBase);
      if (s.kind == Surface::Kind::ramp) s.height2_m = number(kHeight2);
      const double size = s.kind != Surface::Kind::cylinder ? (s.to - s.from).norm() : s.half_width_m;
      const bool has_width = s.kind != Surface::Kind::floor && s.kind != Surface::Kind::ramp ? s.half_width_m >= 0.0
                                                                                             : s.half_width_m > 0.0;
      if (!(size > 0.0) || !has_width || !(std::max(s.height_m, s.height2_m) > s.base_m))
        throw DataError(fmt::format("{}: a thing without size; length or radius and height above 0 are expected",
                                    table.place(row)));
    }
    if (s.kind == Surface::Kind::ground || s.kind == Surface::Kind::floor || s.kind == Surface::Kind::ramp)
      s.waves = waves;
    surfaces.push_back(s);
  }
  return surfaces;
}

double distance(const Surface& surface, const Eigen::Vector3d& p) {
  const Top top = top_at(surface, p.head<2>());
  const double above = (p.z() - top.z) / std::sqrt(1.0 + top.slope * top.slope);
  if (is_endless(surface)) return std::abs(above);
  const double aside = beside(surface, p.head<2>());
  const double below = surface.base_m - p.z();
  const double beyond = std::max(above, below);
  if (aside > 0.0 || beyond > 0.0) return std::hypot(std::max(aside, 0.0), std::max(beyond, 0.0));
  const double inside = std::min(-aside, -above);
  return surface.kind == Surface::Kind::floor ? std::min(inside, -below) : inside;
}

void for_points_on(const Surface& surface, const Region& region, double spacing_m,
                   const std::function<void(const Eigen::Vector3d&)>& visit) {
  const auto offer = [&](const Eigen::Vector2d& p, double z) {
    const Eigen::Vector3d point(p.x(), p.y(), z);
    if (region.holds(point)) visit(point);
  };
  const bool is_flat = surface.kind != Surface::Kind::ramp && (!surface.waves || surface.waves->empty());
  const bool is_seen = !is_flat || (surface.height_m >= region.low.z() && surface.height_m < region.high.z());
  if (is_seen) {
    for_top(surface, region, spacing_m, [&](const Eigen::Vector2d& p) { offer(p, top_at(surface, p).z); });
  }
  if (is_endless(surface)) return;
  if (surface.kind == Surface::Kind::floor)
    for_top(surface, region, spacing_m, [&](const Eigen::Vector2d& p) { offer(p, surface.base_m); });
  for_outline(surface, spacing_m, [&](const Eigen::Vector2d& p) {
    for_pieces(surface.base_m, top_at(surface, p).z, spacing_m, [&](double z) { offer(p, z); });
  });
}

}  // namespace waymark::evaluation
