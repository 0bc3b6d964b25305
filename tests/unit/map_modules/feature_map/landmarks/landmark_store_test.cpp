// SPDX-License-Identifier: Apache-2.0
#include "map_modules/feature_map/landmarks/landmark_store.hpp"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <sstream>

#include "tests/unit/map_modules/feature_map/feature_map_bench.hpp"
#include "waymark/math/random.hpp"

namespace waymark::feature_map {
namespace {

using feature_map_test::landmark_at;

LandmarkRef find(const LandmarkStore& store, std::int64_t id) {
  LandmarkRef found;
  store.for_near({0.0, 0.0}, 1e6, [&](LandmarkRef ref, const Landmark& landmark) {
    if (landmark.id == id) found = ref;
  });
  return found;
}

/// id → (east, north) of everything in the store.
std::map<std::int64_t, std::pair<double, double>> content(const LandmarkStore& store) {
  std::map<std::int64_t, std::pair<double, double>> all;
  store.for_all([&](const Landmark& landmark) { all[landmark.id] = {landmark.mean.x(), landmark.mean.y()}; });
  return all;
}

LandmarkStore scattered(int count, std::uint64_t seed = 5) {
  Random random({.seed = seed, .slot = 0, .stamp = 0, .sensor = 0});
  LandmarkStore store;
  for (int i = 0; i < count; ++i) {
    const double east = 200.0 * random.uniform() - 100.0;
    store.add(landmark_at(east, 200.0 * random.uniform() - 100.0));
  }
  return store;
}

std::string bytes_of(const std::vector<const LandmarkStore*>& stores) {
  std::ostringstream stream;
  OutArchive out(stream);
  for (const LandmarkStore* store : stores) store->save(out);
  return stream.str();
}

TEST(LandmarkStore, EveryLandmarkGetsAnIdOfItsOwn) {
  LandmarkStore store;
  std::set<std::int64_t> ids;
  for (int i = 0; i < 100; ++i) ids.insert(store.add(landmark_at(i, -i)));
  EXPECT_EQ(ids.size(), 100u);
  EXPECT_EQ(store.size(), 100u);
  EXPECT_EQ(content(store).size(), 100u);
}

TEST(LandmarkStore, AWriteKeepsTheId) {
  LandmarkStore store;
  const auto id = store.add(landmark_at(1.0, 2.0));
  Landmark moved = landmark_at(1.5, 2.5);
  moved.id = 77;
  store.write(find(store, id), moved);
  EXPECT_EQ(content(store), (std::map<std::int64_t, std::pair<double, double>>{{id, {1.5, 2.5}}}));
}

TEST(LandmarkStore, AnErasedPlaceIsUsedAgainUnderAFreshId) {
  LandmarkStore store;
  std::vector<std::int64_t> ids;
  for (int i = 0; i < LandmarkStore::kLeafSize; ++i) ids.push_back(store.add(landmark_at(0.1 * i, 0.0)));
  const LandmarkRef place = find(store, ids[3]);
  store.erase(place);
  EXPECT_EQ(store.size(), ids.size() - 1);
  EXPECT_EQ(find(store, ids[3]).chunk, -1);
  const auto fresh = store.add(landmark_at(0.35, 0.0));
  EXPECT_EQ(std::count(ids.begin(), ids.end(), fresh), 0);
  EXPECT_EQ(find(store, fresh).chunk, place.chunk);
  EXPECT_EQ(find(store, fresh).place, place.place);
}

TEST(LandmarkStore, ACopyIsUntouchedByWrites) {
  LandmarkStore store = scattered(100);
  const auto before = content(store);
  const LandmarkStore copy = store;
  store.write(find(store, 10), landmark_at(0.0, 0.0));
  store.erase(find(store, 11));
  store.add(landmark_at(5.0, 5.0));
  EXPECT_EQ(content(copy), before);
  EXPECT_NE(content(store), before);
}

TEST(LandmarkStore, OneChangeClonesOneLeaf) {
  const LandmarkStore store = scattered(200);
  LandmarkStore written = store;
  EXPECT_EQ(written.leaves_not_shared_with(store), 0);
  written.write(find(written, 10), landmark_at(0.0, 0.0));
  EXPECT_EQ(written.leaves_not_shared_with(store), 1);
  LandmarkStore erased = store;
  erased.erase(find(erased, 10));
  EXPECT_EQ(erased.leaves_not_shared_with(store), 1);
  LandmarkStore added = store;
  added.add(landmark_at(1.0, 1.0));
  EXPECT_LE(added.leaves_not_shared_with(store), 2);  // a full leaf is split
}

TEST(LandmarkStore, ForNearFindsExactlyWhatIsNear) {
  Random random({.seed = 9, .slot = 0, .stamp = 0, .sensor = 0});
  LandmarkStore store = scattered(300);
  // Landmarks that move, vanish and come anew: the boxes must follow.
  for (int i = 0; i < 300; i += 3) {
    const auto moved = store.at(find(store, i)).mean;
    store.write(find(store, i), landmark_at(moved.x() + 4.0 * random.normal(), moved.y() + 4.0 * random.normal()));
  }
  for (int i = 1; i < 300; i += 5) store.erase(find(store, i));
  for (int i = 0; i < 40; ++i) store.add(landmark_at(100.0 * random.normal(), 100.0 * random.normal()));

  for (int query = 0; query < 200; ++query) {
    const Eigen::Vector2d center(60.0 * random.normal(), 60.0 * random.normal());
    const double radius = 40.0 * random.uniform();
    std::multiset<std::int64_t> found;
    store.for_near(center, radius, [&](LandmarkRef, const Landmark& landmark) { found.insert(landmark.id); });
    std::multiset<std::int64_t> expected;
    for (const auto& [id, p] : content(store)) {
      if ((Eigen::Vector2d(p.first, p.second) - center).norm() <= radius) expected.insert(id);
    }
    ASSERT_EQ(found, expected);
  }
}

TEST(LandmarkStore, ComesBackFromAnArchive) {
  LandmarkStore store = scattered(50);
  store.erase(find(store, 7));
  const std::string bytes = bytes_of({&store});
  std::istringstream stream(bytes);
  InArchive in(stream);
  LandmarkStore loaded;
  loaded.load(in);
  EXPECT_EQ(loaded.size(), 49u);
  EXPECT_EQ(content(loaded), content(store));
  EXPECT_EQ(bytes_of({&loaded}), bytes);
  EXPECT_EQ(loaded.add(landmark_at(0.0, 0.0)), store.add(landmark_at(0.0, 0.0)));
}

TEST(LandmarkStore, WhatIsSharedIsWrittenOnceAndSharedAgain) {
  const LandmarkStore first = scattered(200);
  LandmarkStore second = first;
  second.write(find(second, 10), landmark_at(0.0, 0.0));
  const std::string one = bytes_of({&first});
  const std::string both = bytes_of({&first, &second});
  EXPECT_LT(both.size(), one.size() + one.size() / 4);
  std::istringstream stream(both);
  InArchive in(stream);
  LandmarkStore first_again;
  LandmarkStore second_again;
  first_again.load(in);
  second_again.load(in);
  EXPECT_EQ(content(first_again), content(first));
  EXPECT_EQ(content(second_again), content(second));
  EXPECT_EQ(second_again.leaves_not_shared_with(first_again), 1);
}

}  // namespace
}  // namespace waymark::feature_map
