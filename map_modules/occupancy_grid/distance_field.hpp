// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "tile_window.hpp"

namespace waymark::grid {

/// Keeps the truncated distance of every cell to the nearest occupied one up to date: exactly what a distance transform
/// of the whole map would give. Cells are those of the window, which must reach 2 · `Tile::kReach` cells beyond
/// them; the odds of all of them are written already.
///
/// `freed` were occupied: what they determined is searched anew. `occupied` were not: they bring what is near nearer.
void update_distances(std::span<const Cell> freed, std::span<const Cell> occupied, WritableWindow& window);

}  // namespace waymark::grid
