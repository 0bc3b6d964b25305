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

constexpr std::array<std::string_view, 7> kColumns{"kind", "x_m", "y_m", "x2_m", "y2_m", "half_width_m", "height_m"};
enum Column { kKind, kX, kY, kX2, kY2, kHalfWidth, kHeight };

Surface::Kind kind_of_row(const Table& table, std::size_t row) {
  const std::string& kind = table.field(row, kKind);
  if (kind == "cylinder") return Surface::Kind::cylinder;
  if (kind == "box" || kind == "wall") return Surface::Kind::box;
  if (kind == "level") return Surface::Kind::level;
  throw DataError(fmt::format("{}: kind is \"{}\"; cylinder, box, wall or level is expected", table.place(row), kind));
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
  for_pieces(-s.half_width_m, s.half_width_m, spacing, [&](double at) {
    visit(s.from + at * plan.across());
    visit(s.to + at * plan.across());
  });
}

template <class Visit>
void for_top(const Surface& s, const Region& region, double spacing, const Visit& visit) {
  if (s.kind == Surface::Kind::box) {
    const Plan plan(s);
    for_pieces(-plan.half_length, plan.half_length, spacing, [&](double at) {
      for_pieces(-s.half_width_m, s.half_width_m, spacing,
                 [&](double aside) { visit(plan.middle + at * plan.along + aside * plan.across()); });
    });
    return;
  }
  const bool is_level = s.kind == Surface::Kind::level;
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
  for (std::size_t i = 0; i < kColumns.size(); ++i) {
    if (table.width() == static_cast<int>(kColumns.size()) && table.field(0, static_cast<int>(i)) == kColumns[i])
      continue;
    throw DataError(
        fmt::format("{}: the first row must be kind,x_m,y_m,x2_m,y2_m,half_width_m,height_m", table.place(0)));
  }
  table.drop_first_row();
  std::vector<Surface> surfaces;
  surfaces.reserve(table.rows());
  for (std::size_t row = 0; row < table.rows(); ++row) {
    Surface s;
    s.kind = kind_of_row(table, row);
    const auto number = [&](Column column) { return table.number(row, column, kColumns[column]); };
    s.height_m = number(kHeight);
    if (s.kind != Surface::Kind::level) {
      s.from = s.to = {number(kX), number(kY)};
      s.half_width_m = number(kHalfWidth);
      if (s.kind == Surface::Kind::box) s.to = {number(kX2), number(kY2)};
      const double size = s.kind == Surface::Kind::box ? (s.to - s.from).norm() : s.half_width_m;
      if (!(size > 0.0) || s.half_width_m < 0.0 || !(s.height_m > 0.0))
        throw DataError(fmt::format("{}: a thing without size; length or radius and height above 0 are expected",
                                    table.place(row)));
    }
    surfaces.push_back(s);
  }
  return surfaces;
}

double distance(const Surface& surface, const Eigen::Vector3d& p) {
  const double above = p.z() - surface.height_m;
  if (surface.kind == Surface::Kind::level) return std::abs(above);
  const double aside = beside(surface, p.head<2>());
  const double beyond = std::max(above, -p.z());
  if (aside > 0.0 || beyond > 0.0) return std::hypot(std::max(aside, 0.0), std::max(beyond, 0.0));
  return std::min(-aside, -above);
}

void for_points_on(const Surface& surface, const Region& region, double spacing_m,
                   const std::function<void(const Eigen::Vector3d&)>& visit) {
  const auto offer = [&](const Eigen::Vector2d& p, double z) {
    const Eigen::Vector3d point(p.x(), p.y(), z);
    if (region.holds(point)) visit(point);
  };
  const bool is_seen = surface.height_m >= region.low.z() && surface.height_m < region.high.z();
  if (is_seen) for_top(surface, region, spacing_m, [&](const Eigen::Vector2d& p) { offer(p, surface.height_m); });
  if (surface.kind == Surface::Kind::level) return;
  for_outline(surface, spacing_m, [&](const Eigen::Vector2d& p) {
    for_pieces(0.0, surface.height_m, spacing_m, [&](double z) { offer(p, z); });
  });
}

}  // namespace waymark::evaluation
