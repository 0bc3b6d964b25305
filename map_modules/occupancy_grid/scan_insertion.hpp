// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "map_modules/occupancy_grid/occupancy_grid_settings.hpp"
#include "map_modules/occupancy_grid/scan_observation.hpp"
#include "map_modules/occupancy_grid/tile_window.hpp"

namespace waymark::occupancy_grid {

/// Writes scans into a grid. Holds the storage that this takes, so one of these serves many scans; not thread-safe.
class ScanInsertion {
 public:
  /// Every cell once per scan: those that hold an end point take a hit, those that a beam passes before its end, and
  /// that hold no end point, a miss. Only tiles where something changes are written. `x`, `y` [m] and `yaw` [rad] are
  /// the base's.
  void insert(TileTree& tree, const Eigen::Vector3d& xyyaw, const ScanObservation& scan,
              const OccupancyGridSettings& settings);

 private:
  using Rows = std::array<std::uint32_t, Tile::kSide>;  // one bit a cell
  struct Marks {
    Rows free{};
    Rows hit{};
  };

  Marks& marks_at(std::int32_t x, std::int32_t y) {
    const std::size_t slot = window_.slot(x, y);
    is_marked_[slot] = 1;
    return marks_[slot];
  }
  static std::size_t row_in_tile(std::int32_t y) { return static_cast<std::size_t>(y & (Tile::kSide - 1)); }
  static std::uint32_t bit_in_tile(std::int32_t x) { return 1u << (x & (Tile::kSide - 1)); }
  /// The free cells of the row in which a cell lies, in its tile.
  std::uint32_t& free_row(std::int32_t x, std::int32_t y) { return marks_at(x, y).free[row_in_tile(y)]; }
  void mark_hit(std::int32_t x, std::int32_t y) { marks_at(x, y).hit[row_in_tile(y)] |= bit_in_tile(x); }
  void mark_beam(double from_x, double from_y, double to_x, double to_y);
  void apply(std::size_t slot, const scan_matching::OddsSettings& odds);

  WritableWindow window_;
  std::vector<Marks> marks_;             // per tile of the window; zero between scans
  std::vector<std::uint8_t> is_marked_;  // per tile of the window
  std::vector<Cell> freed_;
  std::vector<Cell> occupied_;
};

}  // namespace waymark::occupancy_grid
