// SPDX-License-Identifier: Apache-2.0
#include "map_modules/occupancy_grid/scan_insertion.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>

#include "map_modules/shared/scan_matching/distance_field.hpp"

namespace waymark::occupancy_grid {

namespace {

int after_hit(int odds, const scan_matching::OddsSettings& s) {
  return std::min((odds == Tile::kUnknown ? 0 : odds) + s.hit, s.high);
}
int after_miss(int odds, const scan_matching::OddsSettings& s) {
  return std::max((odds == Tile::kUnknown ? 0 : odds) + s.miss, s.low);
}

}  // namespace

/// The cells from the beam's beginning to before its end: one in every column (or row, if the beam is steep), where the
/// beam passes its middle. Coordinates in cells of the window.
void ScanInsertion::mark_beam(double from_x, double from_y, double to_x, double to_y) {
  const double dx = to_x - from_x;
  const double dy = to_y - from_y;
  const bool steep = std::abs(dy) > std::abs(dx);
  const double from_major = steep ? from_y : from_x;
  const double from_minor = steep ? from_x : from_y;
  const double slope = steep ? dx / dy : dy / dx;
  const auto first = static_cast<std::int32_t>(from_major);
  const auto end = static_cast<std::int32_t>(steep ? to_y : to_x);
  const std::int32_t step = end >= first ? 1 : -1;
  if (first == end) return;  // also where the beam has no length

  constexpr int kFraction = 16;
  constexpr double kOne = 1 << kFraction;
  auto minor = static_cast<std::int32_t>((from_minor + (first + 0.5 - from_major) * slope) * kOne);
  const auto minor_step = static_cast<std::int32_t>(std::lround(step * slope * kOne));
  for (std::int32_t major = first; major != end; major += step, minor += minor_step) {
    const std::int32_t x = steep ? minor >> kFraction : major;
    const std::int32_t y = steep ? major : minor >> kFraction;
    const std::size_t slot = window_.slot(x, y);
    is_marked_[slot] = 1;
    marks_[slot].free[static_cast<std::size_t>(y & (Tile::kSide - 1))] |= 1u << (x & (Tile::kSide - 1));
  }
}

void ScanInsertion::apply(std::size_t slot, const scan_matching::OddsSettings& odds) {
  Marks& marks = marks_[slot];
  const Cell corner = window_.corner(slot);
  for (int row = 0; row < Tile::kSide; ++row) {
    const auto r = static_cast<std::size_t>(row);
    const std::uint32_t hit = marks.hit[r];
    for (std::uint32_t left_over = hit | marks.free[r]; left_over != 0; left_over &= left_over - 1) {
      const int column = std::countr_zero(left_over);
      const std::size_t place = Tile::place(column, row);
      const std::int8_t before = window_.tile(slot).odds[place];
      const bool is_hit = ((hit >> column) & 1u) != 0;
      const int after = is_hit ? after_hit(before, odds) : after_miss(before, odds);
      if (after == before) continue;  // at its bound: the tile may stay shared
      window_.writable(slot).odds[place] = static_cast<std::int8_t>(after);
      if ((before > 0) != (after > 0)) (after > 0 ? occupied_ : freed_).push_back({corner.x + column, corner.y + row});
    }
    marks.hit[r] = marks.free[r] = 0;
  }
}

void ScanInsertion::insert(TileTree& tree, const Eigen::Vector3d& xyyaw, const ScanObservation& scan,
                           const OccupancyGridSettings& settings) {
  const double margin = settings.resolution * (2 * Tile::kReach + 2);
  window_.open_for_writing(tree, xyyaw.head<2>(), scan.reach + margin, settings.resolution);
  const std::size_t slots = window_.rect().size();
  if (marks_.size() < slots) {
    marks_.resize(slots);
    is_marked_.resize(slots);
  }
  freed_.clear();
  occupied_.clear();

  const double c = std::cos(xyyaw.z()) / settings.resolution;
  const double s = std::sin(xyyaw.z()) / settings.resolution;
  const Cell origin = window_.origin();
  const double x0 = xyyaw.x() / settings.resolution - origin.x;
  const double y0 = xyyaw.y() / settings.resolution - origin.y;
  const auto in_cells = [&](double x, double y) { return Eigen::Vector2d(c * x - s * y + x0, s * x + c * y + y0); };
  const Eigen::Vector2d from = in_cells(scan.p_base_sensor.x(), scan.p_base_sensor.y());
  for (const Eigen::Vector2f& p : scan.hits) {
    const Eigen::Vector2d to = in_cells(static_cast<double>(p.x()), static_cast<double>(p.y()));
    mark_beam(from.x(), from.y(), to.x(), to.y());
    const auto x = static_cast<std::int32_t>(to.x());
    const auto y = static_cast<std::int32_t>(to.y());
    const std::size_t slot = window_.slot(x, y);
    is_marked_[slot] = 1;
    marks_[slot].hit[static_cast<std::size_t>(y & (Tile::kSide - 1))] |= 1u << (x & (Tile::kSide - 1));
  }
  for (const Eigen::Vector2f& p : scan.clear_to) {
    const Eigen::Vector2d to = in_cells(static_cast<double>(p.x()), static_cast<double>(p.y()));
    mark_beam(from.x(), from.y(), to.x(), to.y());
  }
  for (std::size_t slot = 0; slot < slots; ++slot) {
    if (is_marked_[slot] == 0) continue;
    is_marked_[slot] = 0;
    apply(slot, settings.odds);
  }
  scan_matching::update_distances(freed_, occupied_, window_);
}

}  // namespace waymark::occupancy_grid
