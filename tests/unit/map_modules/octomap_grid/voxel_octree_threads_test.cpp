// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <random>
#include <sstream>
#include <thread>
#include <vector>

#include "map_modules/octomap_grid/voxel_octree.hpp"

namespace waymark::octomap_grid {
namespace {

const VoxelOdds kOdds{scan_matching::OddsSettings{17, -8, -40, 70}};

void write_at_random(VoxelOctree& tree, std::mt19937& random) {
  VoxelOctree::Marks marks;
  for (std::size_t i = 0; i < marks.free.size(); ++i) {
    marks.free[i] = random();
    marks.hit[i] = random() & ~marks.free[i];
  }
  std::vector<LocalVoxel> flipped;
  tree.apply(marks, tree.changing(marks, kOdds), kOdds, flipped, flipped);
}

std::string saved(const VoxelOctree& tree) {
  std::ostringstream stream;
  OutArchive out(stream);
  tree.save(out);
  return stream.str();
}

/// Threads write into copies of one octree and drop them; the thread sanitizer reports if one reads what another frees.
TEST(VoxelOctree, ThreadsShareBricks) {
  std::mt19937 random(7);
  VoxelOctree tree;
  write_at_random(tree, random);
  const std::string before = saved(tree);
  constexpr std::size_t kThreads = 3;
  std::array<std::string, kThreads> results;
  std::vector<std::thread> threads;
  threads.reserve(kThreads);
  for (std::size_t t = 0; t < kThreads; ++t) {
    threads.emplace_back([own = tree, &result = results[t]]() mutable {
      std::mt19937 own_random(9);
      for (int i = 0; i < 20; ++i) {
        const VoxelOctree kept = own;
        write_at_random(own, own_random);
        if (i % 3 == 0) own = kept;
      }
      result = saved(own);
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(saved(tree), before);
  for (const std::string& result : results) EXPECT_EQ(result, results.front());
  EXPECT_NE(results.front(), before);
}

}  // namespace
}  // namespace waymark::octomap_grid
