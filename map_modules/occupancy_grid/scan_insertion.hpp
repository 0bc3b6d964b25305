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

  void mark_beam(double from_x, double from_y, double to_x, double to_y);
  void apply(std::size_t slot, const scan_matching::OddsSettings& odds);

  WritableWindow window_;
  std::vector<Marks> marks_;             // per tile of the window; zero between scans
  std::vector<std::uint8_t> is_marked_;  // per tile of the window
  std::vector<Cell> freed_;
  std::vector<Cell> occupied_;
};

}  // namespace waymark::occupancy_grid
