// SPDX-License-Identifier: Apache-2.0
// Thinning a lineage needs memory for what it keeps, and no more: here every byte that the process asks for is counted.
#include "waymark/memory/lineage.hpp"

#include <gtest/gtest.h>

#include <array>
#include <span>
#include <vector>

#include "unit/counted_memory.hpp"

namespace waymark {
namespace {

using Place = std::array<int, 16>;  // as large as a pose with its stamp, about

void extend(Lineage<Place>& lineage, int from, int to) {
  for (int i = from; i < to; ++i) lineage.append({i});
}

std::vector<int> numbers(const Lineage<Place>& lineage) {
  std::vector<int> all;
  for (const Place& item : lineage.items()) all.push_back(item.front());
  return all;
}

TEST(LineageMemory, ThinningAsksForWhatItKeepsOnly) {
  constexpr int kItems = 100'000;
  std::size_t before = counted::bytes;
  Lineage<Place> lineage;
  extend(lineage, 0, kItems);
  const double per_item = static_cast<double>(counted::bytes - before) / kItems;
  const Lineage<Place> mark = lineage;  // as the filter keeps them, to go back to
  extend(lineage, kItems, kItems + 16);

  Lineage<Place>* one = &lineage;
  before = counted::bytes;
  Lineage<Place>::thin(std::span(&one, 1), kItems);
  EXPECT_EQ(lineage.size(), std::size_t{kItems / 2 + 16});
  EXPECT_NEAR(static_cast<double>(counted::bytes - before), per_item * (kItems / 2 + 16), 2000.0);
  EXPECT_EQ(mark.items().size(), std::size_t{kItems}) << "it stays as it was";
}

TEST(Lineage, ListsWhatWasAddedSinceAnother) {
  Lineage<Place> known;
  extend(known, 0, 5);
  Lineage<Place> longer = known;
  extend(longer, 5, 8);
  Lineage<Place> other = known;
  other.drop_last();
  extend(other, 20, 23);
  const auto since = [](const Lineage<Place>& lineage, const Lineage<Place>& before) {
    std::vector<int> all;
    for (const Place& item : lineage.items_since(before)) all.push_back(item.front());
    return all;
  };
  EXPECT_EQ(since(longer, known), (std::vector{4, 5, 6, 7})) << "from the last one that they share";
  EXPECT_EQ(since(known, longer), (std::vector{4}));
  EXPECT_EQ(since(known, known), (std::vector{4}));
  EXPECT_EQ(since(other, longer), (std::vector{3, 20, 21, 22}));
  EXPECT_EQ(since(known, {}), (std::vector{0, 1, 2, 3, 4})) << "all, if they share none";
  Lineage<Place> alike;
  extend(alike, 0, 5);
  EXPECT_EQ(since(known, alike), (std::vector{0, 1, 2, 3, 4}));
  EXPECT_TRUE(since({}, known).empty());
}

/// The branches divide at the 1000th item, which stays or goes. Leaves are shared; one lineage is not thinned.
class LineageSharing : public ::testing::TestWithParam<std::size_t> {};

TEST_P(LineageSharing, IsTheSameAfterThinning) {
  Lineage<Place> root;
  extend(root, 0, 1000);
  const Lineage<Place> left_alone = root;
  std::vector<Lineage<Place>> branches(6, root);
  extend(branches[1], 1000, 1004);
  extend(branches[2], 1000, 1003);
  branches[3] = branches[2];
  extend(branches[3], 2000, 2010);
  extend(branches[4], 3000, 3001);
  std::vector<Lineage<Place>*> all;
  for (Lineage<Place>& branch : branches) all.push_back(&branch);

  std::vector<std::vector<int>> expected;
  for (const Lineage<Place>& branch : branches) {
    std::vector<int>& kept = expected.emplace_back();
    const std::vector<int> before = numbers(branch);
    for (std::size_t i = 0; i < before.size(); ++i) {
      if (i >= GetParam() || i % 2 == 0) kept.push_back(before[i]);
    }
  }
  const std::size_t before = counted::bytes;
  Lineage<Place>::thin(all, GetParam());
  EXPECT_LT(counted::bytes - before, std::size_t{100'000}) << "one trunk for all";
  for (std::size_t i = 0; i < branches.size(); ++i) {
    EXPECT_EQ(numbers(branches[i]), expected[i]) << i;
    EXPECT_EQ(branches[i].size(), expected[i].size()) << i;
  }
  EXPECT_EQ(left_alone.items().size(), 1000U);
}

INSTANTIATE_TEST_SUITE_P(Counts, LineageSharing, ::testing::Values(995, 1000));

}  // namespace
}  // namespace waymark
