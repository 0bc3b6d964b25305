// SPDX-License-Identifier: Apache-2.0
#include "map_modules/occupancy_grid/tile_tree.hpp"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <sstream>
#include <utility>
#include <vector>

#include "waymark/base/error.hpp"

namespace waymark::occupancy_grid {
namespace {

void mark(TileTree& tree, TileIndex index, int value) {
  tree.write(index).odds.set(0, static_cast<std::int8_t>(value));
}

std::string saved(const TileTree& tree) {
  std::ostringstream stream;
  OutArchive out(stream);
  tree.save(out);
  return stream.str();
}

/// Two trees written to one archive, and read again.
struct OnArchive {
  OnArchive(const TileTree& first, const TileTree& second) {
    std::ostringstream stream;
    OutArchive out(stream);
    first.save(out);
    second.save(out);
    size = stream.str().size();
    std::istringstream back(stream.str());
    InArchive in(back);
    parent.load(in);
    child.load(in);
  }
  std::size_t size = 0;
  TileTree parent;
  TileTree child;
};

TEST(TileTree, AnEmptyOneIsUnknownEverywhere) {
  const TileTree tree;
  EXPECT_TRUE(tree.empty());
  EXPECT_EQ(tree.tiles(), 0U);
  EXPECT_EQ(&tree.read({3, -7}), &empty_tile());
  EXPECT_EQ(tree.read({0, 0}).odds[5], Tile::kUnknown);
  EXPECT_EQ(tree.read({0, 0}).distances[5], Tile::kFar);
}

TEST(TileTree, HoldsWhatWasWrittenHoweverFarItGrows) {
  TileTree tree;
  std::map<std::pair<int, int>, int> expected;
  std::mt19937 random(7);
  for (int span = 3; span < 20'000'000; span *= 4) {
    std::uniform_int_distribution<int> place(-span, span);
    for (int i = 0; i < 20; ++i) {
      const TileIndex index{place(random), place(random)};
      mark(tree, index, i);
      expected[{index.x, index.y}] = i;
    }
  }
  mark(tree, {TileTree::kMaxIndex, -TileTree::kMaxIndex}, 99);
  expected[{TileTree::kMaxIndex, -TileTree::kMaxIndex}] = 99;
  for (const auto& [index, value] : expected) EXPECT_EQ(tree.read({index.first, index.second}).odds[0], value);
  EXPECT_EQ(tree.tiles(), expected.size());
  std::size_t visited = 0;
  tree.for_all([&](TileIndex index, const Tile& tile, bool is_shared) {
    ++visited;
    EXPECT_FALSE(is_shared);
    EXPECT_EQ(tile.odds[0], expected.at({index.x, index.y}));
  });
  EXPECT_EQ(visited, expected.size());
}

TEST(TileTree, AMapAboutTheOriginStaysLow) {
  TileTree tree;
  for (int x = -4; x < 4; ++x) {
    for (int y = -4; y < 4; ++y) mark(tree, {x, y}, 1);
  }
  EXPECT_EQ(tree.height(), 1);
}

TEST(TileTree, GathersARectangle) {
  TileTree tree;
  std::mt19937 random(3);
  std::uniform_int_distribution<int> place(-40, 40);
  for (int i = 0; i < 500; ++i) mark(tree, {place(random), place(random)}, i % 100 + 1);
  const scan_matching::TileRect rect{{-33, -12}, {25, 47}};
  std::vector<const Tile*> found(rect.size());
  tree.gather(rect, found);
  for (int y = rect.low.y; y <= rect.high.y; ++y) {
    for (int x = rect.low.x; x <= rect.high.x; ++x) {
      const auto place_in_rect = static_cast<std::size_t>((y - rect.low.y) * rect.width() + x - rect.low.x);
      ASSERT_EQ(found[place_in_rect], &tree.read({x, y})) << x << " " << y;
    }
  }
}

TEST(TileTree, ACopySharesUntilOneWrites) {
  TileTree tree;
  for (int x = 0; x < 30; ++x) mark(tree, {x, 0}, x);
  const TileTree copy = tree;
  EXPECT_TRUE(copy.shares_root_with(tree));
  mark(tree, {4, 0}, 77);
  EXPECT_EQ(copy.read({4, 0}).odds[0], 4);
  EXPECT_EQ(tree.read({4, 0}).odds[0], 77);
  EXPECT_EQ(&copy.read({5, 0}), &tree.read({5, 0}));
  int own = 0;
  tree.for_all([&](TileIndex, const Tile&, bool is_shared) { own += !is_shared; });
  EXPECT_EQ(own, 1);
  const TileTree* both[] = {&tree, &copy};
  const TileTree* one[] = {&tree};
  EXPECT_GT(TileTree::bytes_of(both), TileTree::bytes_of(one));
  EXPECT_LT(TileTree::bytes_of(both), TileTree::bytes_of(one) + 5 * Tile::kCells);
}

TEST(TileTree, OddsAndDistancesAreSharedByThemselves) {
  TileTree tree;
  mark(tree, {0, 0}, 7);
  tree.write({0, 0}).distances.set(3, 9);
  TileTree copy = tree;
  const TileTree* both[] = {&tree, &copy};
  mark(copy, {0, 0}, 8);
  const std::size_t with_odds = TileTree::bytes_of(both);
  copy.write({0, 0}).distances.set(3, 10);
  EXPECT_EQ(TileTree::bytes_of(both), with_odds + Tile::kStripCells) << "writing odds does not clone distances";
  EXPECT_EQ(tree.read({0, 0}).odds[0], 7);
  EXPECT_EQ(tree.read({0, 0}).distances[3], 9);
  EXPECT_EQ(copy.read({0, 0}).distances[3], 10);
}

TEST(TileTree, StripsOfATileAreSharedByThemselves) {
  TileTree tree;
  for (std::size_t i = 0; i < Tile::kCells; ++i) tree.write({0, 0}).odds.set(i, static_cast<std::int8_t>(i % 100));
  TileTree copy = tree;
  const TileTree* both[] = {&tree, &copy};
  copy.write({0, 0});
  const std::size_t with_tile = TileTree::bytes_of(both);
  copy.write({0, 0}).odds.set(Tile::kCells - 1, 100);
  EXPECT_LE(TileTree::bytes_of(both), with_tile + Tile::kCells / 2);
  for (std::size_t i = 0; i < Tile::kCells; ++i) {
    const auto before = static_cast<std::int8_t>(i % 100);
    ASSERT_EQ(tree.read({0, 0}).odds[i], before);
    ASSERT_EQ(copy.read({0, 0}).odds[i], i + 1 < Tile::kCells ? before : 100);
  }
}

TEST(TileTree, PartsStaySharedOnAnArchive) {
  TileTree parent;
  for (int x = 0; x < 20; ++x) {
    mark(parent, {x, 0}, x);
    parent.write({x, 0}).distances.set(0, static_cast<std::uint8_t>(x));
  }
  TileTree child = parent;
  for (int x = 0; x < 20; ++x) mark(child, {x, 0}, x + 50);
  mark(child, {30, 0}, 1);  // its distances are those that every tile begins with
  OnArchive again(parent, child);
  const TileTree* family[] = {&parent, &child};
  const TileTree* family_again[] = {&again.parent, &again.child};
  EXPECT_EQ(TileTree::bytes_of(family_again), TileTree::bytes_of(family));
  EXPECT_EQ(saved(again.child), saved(child));
}

TEST(TileTree, ComesBackFromAnArchiveAsAFamily) {
  TileTree parent;
  for (int x = -20; x < 20; ++x) mark(parent, {x, 3 * x}, x);
  TileTree child = parent;
  mark(child, {0, 0}, 50);
  OnArchive again(parent, child);
  // The child adds a tile and the nodes on the way, not a second map.
  EXPECT_LT(again.size, saved(parent).size() + 4 * Tile::kCells);
  EXPECT_EQ(saved(again.parent), saved(parent));
  EXPECT_EQ(saved(again.child), saved(child));
  EXPECT_EQ(&again.parent.read({5, 15}), &again.child.read({5, 15}));
  mark(again.child, {5, 15}, 9);
  EXPECT_EQ(again.parent.read({5, 15}).odds[0], 5);
}

TEST(TileTree, RefusesADamagedArchive) {
  TileTree tree;
  mark(tree, {0, 0}, 1);
  mark(tree, {9, 9}, 2);
  std::string bytes = saved(tree);
  const std::size_t height_at = bytes.find("tiles") + 5 + sizeof(std::uint32_t);
  bytes[height_at] = 1;  // it was 2
  std::istringstream back(bytes);
  InArchive in(back);
  TileTree again;
  EXPECT_THROW(again.load(in), DataError);
}

}  // namespace
}  // namespace waymark::occupancy_grid
