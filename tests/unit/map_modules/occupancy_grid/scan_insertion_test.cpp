// SPDX-License-Identifier: Apache-2.0
#include "map_modules/occupancy_grid/scan_insertion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <optional>
#include <random>
#include <set>
#include <utility>

#include "tests/unit/map_modules/occupancy_grid/simulated_room.hpp"
#include "waymark/base/error.hpp"

namespace waymark::occupancy_grid_test {
namespace {

using CellKey = std::pair<int, int>;

const std::vector<Eigen::Vector3d> kPoses = {{0, 0, 0.3}, {-2, 1, -2.0}, {4.5, -2, 1.7}, {1.2, 0.4, 3.0}};

std::int8_t odds_at(const TileTree& tiles, CellKey cell) {
  return tiles.read(Tile::index_of({cell.first, cell.second})).odds[Tile::place(cell.first, cell.second)];
}

/// The cells that a beam passes, found by walking along it in steps much shorter than a cell.
std::set<CellKey> passed(Eigen::Vector2d from, Eigen::Vector2d to, double resolution) {
  std::set<CellKey> cells;
  std::optional<CellKey> last;
  const int steps = static_cast<int>((to - from).norm() / resolution * 200.0) + 1;
  // Numbers, not vectors: without optimisation Eigen takes many times as long.
  const double dx = to.x() - from.x();
  const double dy = to.y() - from.y();
  const double x0 = from.x();
  const double y0 = from.y();
  for (int i = 0; i <= steps; ++i) {
    const CellKey cell{static_cast<int>(std::floor((x0 + dx * i / steps) / resolution)),
                       static_cast<int>(std::floor((y0 + dy * i / steps) / resolution))};
    if (last != cell) cells.insert(cell);  // most steps end in the cell of the step before
    last = cell;
  }
  return cells;
}

/// One scan into an empty map: what every cell must be, by the slow way.
struct Expected {
  std::set<CellKey> hit;
  std::set<CellKey> may_be_free;  // some beam touches it
};

Expected expected_of(const ScanObservation& scan, const Eigen::Vector3d& pose, double resolution) {
  Expected expected;
  const Eigen::Rotation2Dd turn(pose.z());
  const auto in_map = [&](const Eigen::Vector2d& p) -> Eigen::Vector2d { return turn * p + pose.head<2>(); };
  for (const Eigen::Vector2f& p : scan.hits) {
    const Eigen::Vector2d end = in_map(p.cast<double>());
    expected.hit.insert(
        {static_cast<int>(std::floor(end.x() / resolution)), static_cast<int>(std::floor(end.y() / resolution))});
    expected.may_be_free.merge(passed(in_map(scan.p_base_sensor), end, resolution));
  }
  return expected;
}

TEST(ScanInsertion, WritesEveryCellOnceAndEndPointsTakeNoMiss) {
  for (const Eigen::Vector3d& pose : kPoses) {
    const ScanObservation scan = observed(room(), pose);
    TileTree tiles;
    ScanInsertion().insert(tiles, pose, scan, settings());
    const Expected expected = expected_of(scan, pose, 0.05);
    std::size_t free = 0;
    std::size_t hit = 0;
    tiles.for_all([&](TileIndex index, const Tile& tile, bool) {
      for (int i = 0; i < static_cast<int>(Tile::kCells); ++i) {
        const CellKey cell{index.x * Tile::kSide + i % Tile::kSide, index.y * Tile::kSide + i / Tile::kSide};
        const std::int8_t odds = tile.odds[static_cast<std::size_t>(i)];
        if (expected.hit.contains(cell)) {
          EXPECT_EQ(odds, 17);
          ++hit;
        } else if (odds != Tile::kUnknown) {
          EXPECT_EQ(odds, -8);
          ++free;
          // A beam is followed along its longer axis, so a cell may be one that it passes by less than a cell.
          bool near = false;
          for (int dx = -1; dx <= 1; ++dx) {
            for (int dy = -1; dy <= 1; ++dy)
              near = near || expected.may_be_free.contains({cell.first + dx, cell.second + dy});
          }
          EXPECT_TRUE(near) << cell.first << " " << cell.second;
        }
      }
    });
    EXPECT_EQ(hit, expected.hit.size());
    EXPECT_GT(free, expected.may_be_free.size() / 2);
    EXPECT_LE(free, expected.may_be_free.size());
  }
}

TEST(ScanInsertion, FollowsASingleBeamInEveryDirection) {
  for (int degrees = 0; degrees < 360; degrees += 7) {
    const double yaw = degrees * 0.0174532925;
    ScanObservation scan;
    scan.hits.push_back({3.0f, 0.0f});
    scan.reach = 3.0;
    TileTree tiles;
    const Eigen::Vector3d pose(0.013, -0.027, yaw);
    ScanInsertion().insert(tiles, pose, scan, settings());
    const Expected expected = expected_of(scan, pose, 0.05);
    int free = 0;
    for (const CellKey& cell : expected.may_be_free) free += odds_at(tiles, cell) == -8;
    const double longer = std::max(std::abs(std::cos(yaw)), std::abs(std::sin(yaw)));
    EXPECT_NEAR(free, 60.0 * longer, 2.0) << degrees;
  }
}

TEST(ScanInsertion, OddsStayWithinTheirBounds) {
  TileTree tiles;
  ScanInsertion insertion;
  const ScanObservation scan = observed(room(), kPoses[0]);
  for (int i = 0; i < 20; ++i) insertion.insert(tiles, kPoses[0], scan, settings());
  int low = 0;
  int high = 0;
  tiles.for_all([&](TileIndex, const Tile& tile, bool) {
    for (std::size_t i = 0; i < Tile::kCells; ++i) {
      const std::int8_t odds = tile.odds[i];
      EXPECT_TRUE(odds == Tile::kUnknown || odds == -40 || odds == 70) << int{odds};
      low += odds == -40;
      high += odds == 70;
    }
  });
  EXPECT_GT(low, 1000);
  EXPECT_GT(high, 50);
}

TEST(ScanInsertion, WhatChangesNothingKeepsTilesShared) {
  TileTree tiles;
  ScanInsertion insertion;
  const ScanObservation scan = observed(room(), kPoses[0]);
  for (int i = 0; i < 20; ++i) insertion.insert(tiles, kPoses[0], scan, settings());
  TileTree copy = tiles;
  insertion.insert(copy, kPoses[0], scan, settings());
  EXPECT_TRUE(copy.shares_root_with(tiles));
}

TEST(ScanInsertion, BeamsWithoutReturnClearOnlyIfAsked) {
  LaserScan nothing;
  nothing.step_rad = 0.01;
  nothing.ranges_m.assign(10, 81.0f);
  EXPECT_THROW(observe(nothing, Pose{}, {}, settings().scan), DataError);
  const OccupancyGridSettings clears = settings("{ no_return_clears_m: 2 }");
  TileTree tiles;
  ScanInsertion().insert(tiles, Eigen::Vector3d::Zero(), observe(nothing, Pose{}, {}, clears.scan), clears);
  EXPECT_EQ(odds_at(tiles, {20, 1}), -8);
  tiles.for_all([&](TileIndex, const Tile& tile, bool) {
    for (std::size_t i = 0; i < Tile::kCells; ++i) EXPECT_LE(tile.odds[i], 0);
  });
}

/// The distance of every cell to the nearest occupied one, over all pairs.
void expect_exact_distances(const TileTree& tiles) {
  std::vector<CellKey> occupied;
  tiles.for_all([&](TileIndex index, const Tile& tile, bool) {
    for (int i = 0; i < static_cast<int>(Tile::kCells); ++i) {
      if (Tile::is_occupied(tile.odds[static_cast<std::size_t>(i)]))
        occupied.push_back({index.x * Tile::kSide + i % Tile::kSide, index.y * Tile::kSide + i / Tile::kSide});
    }
  });
  ASSERT_GT(occupied.size(), 20U);
  std::map<CellKey, int> nearest;  // squared, within reach
  for (const CellKey& o : occupied) {
    for (int y = -Tile::kReach; y <= Tile::kReach; ++y) {
      for (int x = -Tile::kReach; x <= Tile::kReach; ++x) {
        const int square = x * x + y * y;
        if (square > Tile::kReach * Tile::kReach) continue;
        const auto [it, is_new] = nearest.try_emplace({o.first + x, o.second + y}, square);
        if (!is_new) it->second = std::min(it->second, square);
      }
    }
  }
  std::size_t found = 0;
  tiles.for_all([&](TileIndex index, const Tile& tile, bool) {
    for (int i = 0; i < static_cast<int>(Tile::kCells); ++i) {
      const CellKey cell{index.x * Tile::kSide + i % Tile::kSide, index.y * Tile::kSide + i / Tile::kSide};
      const int stored = tile.distances[static_cast<std::size_t>(i)];
      const auto it = nearest.find(cell);
      if (it == nearest.end()) {
        ASSERT_EQ(stored, Tile::kFar) << cell.first << " " << cell.second;
      } else {
        ++found;
        ASSERT_EQ(stored, std::lround(Tile::kDistanceSteps * std::sqrt(it->second)))
            << cell.first << " " << cell.second;
      }
    }
  });
  EXPECT_EQ(found, nearest.size());
}

TEST(ScanInsertion, DistancesAreThoseOfADistanceTransform) {
  // Poses with errors, so that walls appear, wander and vanish again.
  std::mt19937 random(11);
  std::normal_distribution<double> error(0.0, 1.0);
  TileTree tiles;
  ScanInsertion insertion;
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector3d pose = kPoses[static_cast<std::size_t>(i) % kPoses.size()];
    const Eigen::Vector3d wrong =
        pose + Eigen::Vector3d(0.1 * error(random), 0.1 * error(random), 0.03 * error(random));
    insertion.insert(tiles, wrong, observed(room(), pose, 0.02, static_cast<std::uint32_t>(i)), settings());
    if (i % 12 == 11) expect_exact_distances(tiles);
  }
}

}  // namespace
}  // namespace waymark::occupancy_grid_test
