// SPDX-License-Identifier: Apache-2.0
#include "map_modules/occupancy_grid/scan_insertion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "map_modules/shared/scan_matching/distance_field.hpp"

namespace waymark::occupancy_grid {

namespace {

/// One byte per bit of a byte: 0 or −1.
constexpr std::array<std::array<std::int8_t, 8>, 256> kBytesOfBits = [] {
  std::array<std::array<std::int8_t, 8>, 256> table{};
  for (std::size_t bits = 0; bits < table.size(); ++bits) {
    for (std::size_t i = 0; i < 8; ++i) table[bits][i] = static_cast<std::int8_t>(-static_cast<int>(bits >> i & 1));
  }
  return table;
}();

using RowMask = std::array<std::int8_t, Tile::kSide>;

RowMask mask_of(std::uint32_t bits) {
  RowMask mask;
  for (std::size_t i = 0; i < Tile::kSide; i += 8) std::ranges::copy(kBytesOfBits[bits >> i & 0xFF], mask.begin() + i);
  return mask;
}

bool has_any(const RowMask& bytes) {
  std::array<std::uint64_t, Tile::kSide / 8> words;
  std::memcpy(words.data(), bytes.data(), bytes.size());
  return std::ranges::any_of(words, [](std::uint64_t word) { return word != 0; });
}

struct ChangedRow {
  std::array<std::int8_t, Tile::kSide> odds;
  bool is_changed;
  bool crosses;  // a cell became occupied, or ceased to be
};

/// A row of cells after hits and misses. All in bytes and without branches, so that a compiler computes sixteen cells
/// at once.
ChangedRow changed(const std::int8_t* before, const RowMask& hit, const RowMask& marked,
                   const scan_matching::OddsSettings& s) {
  const auto high = static_cast<std::int8_t>(s.high);
  const auto low = static_cast<std::int8_t>(s.low);
  const auto up = static_cast<std::int8_t>(s.hit);
  const auto down = static_cast<std::int8_t>(s.miss);
  const auto last_up = static_cast<std::int8_t>(s.high - s.hit);
  const auto last_down = static_cast<std::int8_t>(s.low - s.miss);
  ChangedRow row;
  RowMask changes;
  RowMask crossings;
  for (std::size_t i = 0; i < Tile::kSide; ++i) {
    const std::int8_t old = before[i];
    const std::int8_t odds = old == Tile::kUnknown ? std::int8_t{0} : old;
    const std::int8_t more = odds > last_up ? high : static_cast<std::int8_t>(odds + up);
    const std::int8_t less = odds < last_down ? low : static_cast<std::int8_t>(odds + down);
    const std::int8_t moved = hit[i] != 0 ? more : less;
    const std::int8_t after = marked[i] != 0 ? moved : old;
    row.odds[i] = after;
    changes[i] = static_cast<std::int8_t>(after ^ old);
    crossings[i] = static_cast<std::int8_t>((after > 0) ^ (old > 0));
  }
  row.is_changed = has_any(changes);
  row.crosses = has_any(crossings);
  return row;
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
  if (steep) {
    Cell last{minor >> kFraction, first};
    Marks* marks = &marks_at(last.x, last.y);
    for (std::int32_t y = first; y != end; y += step, minor += minor_step) {
      const std::int32_t x = minor >> kFraction;
      if (((x ^ last.x) | (y ^ last.y)) >> Tile::kBits != 0) marks = &marks_at(x, y);
      last = {x, y};
      marks->free[row_in_tile(y)] |= bit_in_tile(x);
    }
    return;
  }
  // Cells of one row and tile are collected: each is a bit of the same word.
  std::int32_t row = minor >> kFraction;
  std::int32_t x = first;
  std::uint32_t bits = 0;
  for (std::int32_t next = first; next != end; next += step, minor += minor_step) {
    const std::int32_t y = minor >> kFraction;
    if (y != row || (next ^ x) >> Tile::kBits != 0) {
      free_row(x, row) |= bits;
      bits = 0;
      row = y;
    }
    x = next;
    bits |= bit_in_tile(x);
  }
  free_row(x, row) |= bits;
}

void ScanInsertion::apply(std::size_t slot, const scan_matching::OddsSettings& odds) {
  Marks& marks = marks_[slot];
  const Cell corner = window_.corner(slot);
  for (int y = 0; y < Tile::kSide; ++y) {
    const auto r = static_cast<std::size_t>(y);
    const std::uint32_t marked = marks.hit[r] | marks.free[r];
    if (marked == 0) continue;
    const std::int8_t* before = window_.odds_at(corner.x, corner.y + y);
    const ChangedRow row = changed(before, mask_of(marks.hit[r]), mask_of(marked), odds);
    marks.hit[r] = marks.free[r] = 0;
    if (!row.is_changed) continue;  // all are at their bounds: the tile may stay shared
    for (std::size_t x = 0; row.crosses && x < Tile::kSide; ++x) {
      if ((before[x] > 0) == (row.odds[x] > 0)) continue;
      (row.odds[x] > 0 ? occupied_ : freed_).push_back({corner.x + static_cast<std::int32_t>(x), corner.y + y});
    }
    std::ranges::copy(row.odds, window_.writable_odds_at(corner.x, corner.y + y));
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
    mark_hit(static_cast<std::int32_t>(to.x()), static_cast<std::int32_t>(to.y()));
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
