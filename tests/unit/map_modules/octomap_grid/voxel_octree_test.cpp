// SPDX-License-Identifier: Apache-2.0
#include "map_modules/octomap_grid/voxel_octree.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <initializer_list>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <sstream>

#include "waymark/base/error.hpp"

namespace waymark::octomap_grid {
namespace {

constexpr int kSide = VoxelOctree::kSide;

const VoxelOdds kOdds{scan_matching::OddsSettings{17, -8, -40, 70}};

void mark(VoxelOctree::Bits& bits, int x, int y, int z) {
  const std::size_t place = VoxelOctree::place(x, y, z);
  bits[place >> 6] |= std::uint64_t{1} << (place & 63);
}
bool is_marked(const VoxelOctree::Bits& bits, int x, int y, int z) {
  const std::size_t place = VoxelOctree::place(x, y, z);
  return (bits[place >> 6] >> (place & 63) & 1) != 0;
}

/// A block that is free, with an uneven border, and a wall behind it.
VoxelOctree::Marks scan(std::mt19937& random) {
  VoxelOctree::Marks marks;
  std::uniform_int_distribution<int> depth(5, 12);
  for (int y = 0; y < kSide; ++y) {
    for (int z = 0; z < kSide; ++z) {
      const int end = depth(random);
      for (int x = 0; x < end; ++x) mark(marks.free, x, y, z);
      mark(marks.hit, end, y, z);
    }
  }
  return marks;
}

std::string saved(const VoxelOctree& tree) {
  std::ostringstream stream;
  OutArchive out(stream);
  tree.save(out);
  return stream.str();
}

void apply(VoxelOctree& tree, const VoxelOctree::Marks& marks, std::vector<LocalVoxel>& occupied,
           std::vector<LocalVoxel>& freed) {
  tree.apply(marks, tree.changing(marks, kOdds), kOdds, occupied, freed);
}

std::size_t bytes_of(std::initializer_list<const VoxelOctree*> trees) {
  std::set<const void*> seen;
  std::size_t sum = 0;
  for (const VoxelOctree* tree : trees) sum += tree->bytes(seen);
  return sum;
}

std::optional<float> at(const VoxelOctree& tree, int x, int y, int z) {
  const float* found =
      tree.find({static_cast<std::uint8_t>(x), static_cast<std::uint8_t>(y), static_cast<std::uint8_t>(z)});
  return found == nullptr ? std::nullopt : std::optional(*found);
}

TEST(VoxelOctree, HoldsWhatAnArrayWouldHold) {
  std::mt19937 random(5);
  VoxelOctree tree;
  std::map<std::array<int, 3>, float> expected;
  for (int i = 0; i < 40; ++i) {
    const VoxelOctree::Marks marks = scan(random);
    std::vector<LocalVoxel> occupied;
    std::vector<LocalVoxel> freed;
    apply(tree, marks, occupied, freed);
    std::size_t now_occupied = 0;
    std::size_t now_free = 0;
    for (int x = 0; x < kSide; ++x) {
      for (int y = 0; y < kSide; ++y) {
        for (int z = 0; z < kSide; ++z) {
          const bool hit = is_marked(marks.hit, x, y, z);
          if (!hit && !is_marked(marks.free, x, y, z)) continue;
          float& value = expected.try_emplace({x, y, z}, 0.0f).first->second;
          const bool before = value > 0.0f;
          value = hit ? kOdds.after_hit(value) : kOdds.after_miss(value);
          now_occupied += !before && value > 0.0f;
          now_free += before && value <= 0.0f;
        }
      }
    }
    ASSERT_EQ(occupied.size(), now_occupied);
    ASSERT_EQ(freed.size(), now_free);
    for (const LocalVoxel v : occupied) ASSERT_GT(*at(tree, v.x, v.y, v.z), 0.0f);
    for (const LocalVoxel v : freed) ASSERT_LE(*at(tree, v.x, v.y, v.z), 0.0f);
  }
  for (int x = 0; x < kSide; ++x) {
    for (int y = 0; y < kSide; ++y) {
      for (int z = 0; z < kSide; ++z) {
        const auto it = expected.find({x, y, z});
        ASSERT_EQ(at(tree, x, y, z), it == expected.end() ? std::nullopt : std::optional(it->second));
      }
    }
  }
  // Free space at its bound is one leaf, not voxels; and all leaves together are what is known.
  EXPECT_LT(tree.nodes(), expected.size());
  std::size_t voxels = 0;
  tree.for_all([&](LocalVoxel v, int side, float odds) {
    voxels += static_cast<std::size_t>(side * side * side);
    EXPECT_EQ(odds, expected.at({v.x + side - 1, v.y, v.z}));
  });
  EXPECT_EQ(voxels, expected.size());
}

TEST(VoxelOctree, SaysWhetherAScanWouldChangeIt) {
  std::mt19937 random(1);
  const VoxelOctree::Marks marks = scan(random);
  VoxelOctree tree;
  std::vector<LocalVoxel> changed;
  int scans = 0;
  for (; tree.changing(marks, kOdds) != 0 && scans < 100; ++scans) {
    const std::string before = saved(tree);
    apply(tree, marks, changed, changed);
    EXPECT_NE(saved(tree), before);
  }
  EXPECT_EQ(scans, 5);  // 5 misses of 0.4 make −2, 5 hits of 0.85 more than 3.5
  const std::string before = saved(tree);
  apply(tree, marks, changed, changed);
  EXPECT_EQ(saved(tree), before);
}

TEST(VoxelOctree, ACopyIsItsOwn) {
  std::mt19937 random(2);
  VoxelOctree tree;
  std::vector<LocalVoxel> changed;
  apply(tree, scan(random), changed, changed);
  const VoxelOctree copy = tree;
  EXPECT_EQ(saved(copy), saved(tree));
  EXPECT_EQ(bytes_of({&tree, &copy}), bytes_of({&tree}));
  const std::string before = saved(copy);
  apply(tree, scan(random), changed, changed);
  EXPECT_EQ(saved(copy), before);
  EXPECT_NE(saved(tree), before);
  tree = copy;
  EXPECT_EQ(saved(tree), before);
  const VoxelOctree moved = std::move(tree);
  EXPECT_EQ(saved(moved), before);
}

/// A write makes the bricks anew in which something changes; the others stay with both.
TEST(VoxelOctree, AWriteClonesTheBricksThatChange) {
  std::mt19937 random(4);
  VoxelOctree tree;
  std::vector<LocalVoxel> changed;
  for (int i = 0; i < 10; ++i) apply(tree, scan(random), changed, changed);
  const std::size_t all = bytes_of({&tree});
  for (const bool in_two : {false, true}) {
    VoxelOctree::Marks marks;
    mark(marks.hit, 1, 2, 3);
    if (in_two) mark(marks.hit, 9, 2, 3);
    VoxelOctree copy = tree;
    ASSERT_TRUE(copy.changing(marks, kOdds) != 0);
    apply(copy, marks, changed, changed);
    const std::size_t own = bytes_of({&tree, &copy}) - all;
    EXPECT_GT(own, in_two ? sizeof(VoxelBrick::Blocks) : 0);
    EXPECT_LT(own, in_two ? all / 2 : all / 4);
    EXPECT_NE(saved(copy), saved(tree));
  }
  // What is not known, and what is as free as it can be, takes no brick of its own.
  VoxelOctree::Marks everywhere;
  everywhere.free.fill(~std::uint64_t{0});
  VoxelOctree free;
  for (int i = 0; i < 10; ++i) apply(free, everywhere, changed, changed);
  EXPECT_EQ(bytes_of({&free}), 0U);
  EXPECT_EQ(free.nodes(), 1U);
}

/// Bricks and their values are freed with the last map that holds them; the sanitizers report if not.
TEST(VoxelOctree, BricksOutliveTheMapThatMadeThem) {
  std::mt19937 random(6);
  std::vector<LocalVoxel> changed;
  auto first = std::make_unique<VoxelOctree>();
  apply(*first, scan(random), changed, changed);
  VoxelOctree second = *first;
  const std::string before = saved(second);
  apply(*first, scan(random), changed, changed);
  first.reset();
  EXPECT_EQ(saved(second), before);
  second = VoxelOctree();
  EXPECT_TRUE(second.is_unknown());
}

/// The same content is the same bytes, whatever came before.
TEST(VoxelOctree, HoldsNothingOfItsHistory) {
  std::mt19937 random(8);
  VoxelOctree tree;
  std::vector<LocalVoxel> changed;
  for (int i = 0; i < 12; ++i) {
    apply(tree, scan(random), changed, changed);
    VoxelOctree::Draft draft;
    tree.for_all(
        [&](LocalVoxel v, int side, float odds) { draft.set(v, std::countr_zero(static_cast<unsigned>(side)), odds); });
    ASSERT_EQ(saved(VoxelOctree(draft)), saved(tree));
  }
}

TEST(VoxelOctree, ComesBackFromAnArchive) {
  std::mt19937 random(3);
  VoxelOctree tree;
  std::vector<LocalVoxel> changed;
  apply(tree, scan(random), changed, changed);
  std::string bytes = saved(tree);
  std::istringstream stream(bytes);
  InArchive in(stream);
  VoxelOctree again;
  again.load(in);
  EXPECT_EQ(saved(again), bytes);
  EXPECT_EQ(again.nodes(), tree.nodes());

  const auto load = [](const std::string& content) {
    std::istringstream from_stream(content);
    InArchive from(from_stream);
    VoxelOctree tree_read;
    try {
      tree_read.load(from);
    } catch (const DataError&) {
      EXPECT_TRUE(tree_read.is_unknown());
      return false;
    }
    tree_read.nodes();  // and the sanitizers report if that reads beyond
    return true;
  };
  for (std::size_t length = 0; length < bytes.size(); length += 37) EXPECT_FALSE(load(bytes.substr(0, length)));
  int refused = 0;
  for (std::size_t i = 0; i < std::min<std::size_t>(bytes.size(), 400); ++i) {
    std::string damaged = bytes;
    damaged[i] = static_cast<char>(~damaged[i]);
    refused += load(damaged) ? 0 : 1;
  }
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace waymark::octomap_grid
