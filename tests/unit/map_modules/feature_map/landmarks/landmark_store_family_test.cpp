// SPDX-License-Identifier: Apache-2.0
// Stores that descend from each other: what they share, what they cost, and that none sees what another one does.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <sstream>

#include "tests/unit/map_modules/feature_map/feature_map_bench.hpp"
#include "waymark/base/error.hpp"
#include "waymark/math/random.hpp"

namespace waymark::feature_map {
namespace {

using feature_map_test::landmark_at;

Random stream(std::uint32_t slot) { return Random({.seed = 21, .slot = slot, .stamp = 0, .sensor = 0}); }

/// `count` landmarks at a density of one per 25 m².
LandmarkStore field(int count) {
  Random random = stream(0);
  const double side = 5.0 * std::sqrt(static_cast<double>(count));
  LandmarkStore store;
  for (int i = 0; i < count; ++i) {
    const double east = side * random.uniform();
    store.add(landmark_at(east, side * random.uniform()));
  }
  return store;
}

struct Item {
  LandmarkRef ref;
  Landmark landmark;
};

std::vector<Item> items(const LandmarkStore& store, const Eigen::Vector2d& center = {0.0, 0.0}, double radius = 1e6) {
  std::vector<Item> all;
  store.for_near(center, radius, [&](LandmarkRef ref, const Landmark& landmark) { all.push_back({ref, landmark}); });
  return all;
}

std::size_t bytes_of(const std::vector<LandmarkStore>& stores) {
  std::vector<const LandmarkStore*> handles;
  for (const LandmarkStore& store : stores) handles.push_back(&store);
  return LandmarkStore::bytes_of(handles);
}

TEST(LandmarkStoreFamily, ACopySharesTheRoot) {
  for (const int count : {10, 1000, 20000}) {
    const LandmarkStore store = field(count);
    const LandmarkStore copy = store;
    EXPECT_TRUE(copy.shares_root_with(store));
    const LandmarkStore* both[] = {&store, &copy};
    EXPECT_EQ(LandmarkStore::bytes_of(both), LandmarkStore::bytes_of({both, 1}));
  }
}

TEST(LandmarkStoreFamily, TheHeightIsLogarithmic) {
  // Half full nodes and leaves are the worst that splitting makes: 16 · 4^height landmarks or more.
  for (const int count : {100, 1000, 10000, 100000})
    EXPECT_LE(field(count).height(), 1 + std::ceil(std::log(count / 16.0) / std::log(4.0))) << count;
}

struct Touch {
  int landmarks;
  int leaves;
};
class FamilyMemory : public ::testing::TestWithParam<Touch> {};

// 100 particles that descend from one and write: one map, and per particle the leaves it wrote with half as much again
// for the way to them.
TEST_P(FamilyMemory, IsOneMapAndTheLeavesThatWereWritten) {
  constexpr int kParticles = 100;
  const LandmarkStore ancestor = field(GetParam().landmarks);
  ASSERT_LE(GetParam().leaves, std::max(1, ancestor.leaves() / 20));
  std::vector<LandmarkStore> family = {ancestor};
  const std::size_t one_map = bytes_of(family);
  double touched_bytes = 0.0;
  for (std::uint32_t particle = 0; particle < kParticles; ++particle) {
    Random random = stream(particle);
    LandmarkStore store = ancestor;
    const double side = 5.0 * std::sqrt(static_cast<double>(GetParam().landmarks));
    const double east = side * random.uniform();
    const Eigen::Vector2d robot(east, side * random.uniform());
    // The nearest landmarks, until they lie in so many leaves.
    std::vector<Item> near = items(store, robot, std::min(side, 200.0));
    std::ranges::sort(near, {}, [&](const Item& item) { return (item.landmark.mean.head<2>() - robot).norm(); });
    std::set<std::int32_t> leaves;
    for (Item& item : near) {
      if (leaves.size() == static_cast<std::size_t>(GetParam().leaves) && !leaves.contains(item.ref.chunk)) break;
      leaves.insert(item.ref.chunk);
      item.landmark.mean.x() += 0.01;
      store.write(item.ref, item.landmark);
    }
    EXPECT_EQ(store.leaves_not_shared_with(ancestor), static_cast<int>(leaves.size()));
    const LandmarkLeaf leaf;
    touched_bytes += static_cast<double>(leaves.size()) *
                     static_cast<double>(leaf.bytes() + LandmarkLeaf::kSize * 2 * sizeof(float));  // two bins each
    family.push_back(store);
  }
  EXPECT_LE(static_cast<double>(bytes_of(family)), static_cast<double>(one_map) + 1.5 * touched_bytes);
}

INSTANTIATE_TEST_SUITE_P(, FamilyMemory,
                         ::testing::Values(Touch{400, 1}, Touch{10000, 1}, Touch{10000, 2}, Touch{10000, 3},
                                           Touch{10000, 20}),
                         [](const auto& chosen) {
                           return std::to_string(chosen.param.leaves) + "LeavesOf" +
                                  std::to_string(chosen.param.landmarks);
                         });

/// What a store must be: a list.
struct Naive {
  std::map<std::int64_t, Landmark> landmarks;
  std::int64_t next_id = 0;

  std::set<std::int64_t> near(const Eigen::Vector2d& center, double radius) const {
    std::set<std::int64_t> found;
    for (const auto& [id, landmark] : landmarks) {
      if ((landmark.mean.head<2>() - center).norm() <= radius) found.insert(id);
    }
    return found;
  }
};

struct Member {
  LandmarkStore store;
  Naive naive;

  void check(Random& random) const {
    ASSERT_EQ(store.size(), naive.landmarks.size());
    const Eigen::Vector2d center(30.0 * random.normal(), 30.0 * random.normal());
    const double radius = 40.0 * random.uniform();
    std::set<std::int64_t> found;
    store.for_near(center, radius, [&](LandmarkRef ref, StoredLandmark landmark) {
      EXPECT_TRUE(found.insert(landmark.id()).second) << "visited twice";
      EXPECT_EQ(store.at(ref).id, landmark.id());
      const Landmark& expected = naive.landmarks.at(landmark.id());
      EXPECT_EQ(landmark.mean(), expected.mean);
      EXPECT_EQ(landmark.covariance(), expected.P);
      EXPECT_EQ(landmark.log_odds(), expected.log_odds);
      EXPECT_EQ(landmark.sightings(), expected.sightings);
      EXPECT_TRUE(std::ranges::equal(landmark.signature(), expected.signature));
    });
    EXPECT_EQ(found, naive.near(center, radius));
  }
};

/// As a mapping step does it: writes and erases by the refs of one search, then additions.
void step(Member& member, Random& random, double erasing, double adding) {
  const Eigen::Vector2d center(30.0 * random.normal(), 30.0 * random.normal());
  for (Item& item : items(member.store, center, 15.0)) {
    const std::int64_t id = item.landmark.id;
    if (random.uniform() < erasing) {
      member.store.erase(item.ref);
      member.naive.landmarks.erase(id);
    } else if (random.uniform() < 0.3) {
      item.landmark.mean.head<2>() += Eigen::Vector2d(3.0 * random.normal(), 3.0 * random.normal());
      item.landmark.P(0, 1) = item.landmark.P(1, 0) = 1e-4 * random.uniform();
      if (random.uniform() < 0.2) item.landmark.signature = Signature::uniform(3);  // wider than what is there
      item.landmark.sightings += 1;
      member.store.write(item.ref, item.landmark);
      member.naive.landmarks[id] = item.landmark;
    } else if (random.uniform() < 0.3) {
      member.store.write_log_odds(item.ref, 1.5f);
      member.naive.landmarks[id].log_odds = 1.5f;
    }
  }
  for (int i = 0; i < 8; ++i) {
    if (random.uniform() >= adding) continue;
    Landmark fresh = landmark_at(center.x() + 8.0 * random.normal(), center.y() + 8.0 * random.normal());
    if (random.uniform() < 0.5) fresh.signature = {};
    fresh.id = member.store.add(fresh);
    EXPECT_EQ(fresh.id, member.naive.next_id++);
    member.naive.landmarks[fresh.id] = fresh;
  }
}

class RandomFamily : public ::testing::TestWithParam<std::uint32_t> {};

TEST_P(RandomFamily, BehavesAsListsThatNeverShare) {
  Random random = stream(100 + GetParam());
  std::vector<Member> family(5);
  for (int round = 0; round < 600; ++round) {
    auto& member = family[static_cast<std::size_t>(random.uniform() * 5.0)];
    // Times of growth, of balance, and of decay until nothing is left.
    const int phase = round / 100 % 3;
    step(member, random, phase == 0 ? 0.05 : phase == 1 ? 0.2 : 0.9, phase == 2 ? 0.02 : 0.8);
    if (round % 11 == 0) family[static_cast<std::size_t>(random.uniform() * 5.0)] = member;
    for (const Member& one : family) one.check(random);
    if (HasFatalFailure()) FAIL() << "round " << round;
  }
}

INSTANTIATE_TEST_SUITE_P(, RandomFamily, ::testing::Range(0u, 4u));

std::string archive_of(const std::vector<LandmarkStore>& stores) {
  std::ostringstream stream;
  OutArchive out(stream);
  for (const LandmarkStore& store : stores) store.save(out);
  return stream.str();
}

std::vector<LandmarkStore> stores_from(const std::string& archive, std::size_t count) {
  std::istringstream stream(archive);
  InArchive in(stream);
  std::vector<LandmarkStore> stores(count);
  for (LandmarkStore& store : stores) store.load(in);
  return stores;
}

TEST(LandmarkStoreFamily, TheOrderOfVisitsComesFromTheHistoryAndNotFromWhatIsShared) {
  Member alone;
  Member with_relatives;
  Random random = stream(7);
  Random same_random = stream(7);
  for (int round = 0; round < 200; ++round) {
    step(alone, random, 0.1, 0.8);
    const LandmarkStore relative = with_relatives.store;  // every write clones
    step(with_relatives, same_random, 0.1, 0.8);
  }
  EXPECT_EQ(archive_of({alone.store}), archive_of({with_relatives.store}));
  const auto order = [](const LandmarkStore& store) {
    std::vector<std::int64_t> ids;
    store.for_all([&](const StoredLandmark& landmark) { ids.push_back(landmark.id()); });
    return ids;
  };
  EXPECT_EQ(order(alone.store), order(with_relatives.store));
}

TEST(LandmarkStoreFamily, AnEmptiedStoreHoldsNoNodes) {
  LandmarkStore store = field(500);
  for (const Item& item : items(store)) store.erase(item.ref);
  const LandmarkStore* one[] = {&store};
  EXPECT_EQ(LandmarkStore::bytes_of(one), 0u);
  store.add(landmark_at(1.0, 2.0));
  EXPECT_EQ(store.height(), 0);
  EXPECT_EQ(items(store).size(), 1u);
}

TEST(LandmarkStoreFamily, AFamilyComesBackWithWhatItShares) {
  std::vector<Member> family(4);
  Random random = stream(8);
  for (int round = 0; round < 200; ++round) {
    auto& member = family[static_cast<std::size_t>(random.uniform() * 4.0)];
    step(member, random, 0.1, 0.8);
    if (round % 40 == 0) std::ranges::fill(family, member);
  }
  std::vector<LandmarkStore> stores;
  for (const Member& member : family) stores.push_back(member.store);
  const std::string archive = archive_of(stores);
  std::vector<LandmarkStore> again = stores_from(archive, 4);
  EXPECT_EQ(archive_of(again), archive);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(again[i].leaves_not_shared_with(again[0]), stores[i].leaves_not_shared_with(stores[0]));
    Member member{again[i], family[i].naive};
    member.check(random);
    step(member, random, 0.3, 0.8);
    member.check(random);
  }
}

// Any damage must be an error or another legal store: never a crash, never a store that contradicts itself.
TEST(LandmarkStoreFamily, ADamagedArchiveIsNoCrash) {
  const std::string archive = archive_of({field(150)});
  int refused = 0;
  Random random = stream(9);
  for (int trial = 0; trial < 2000; ++trial) {
    std::string damaged = archive;
    const auto at = static_cast<std::size_t>(random.uniform() * static_cast<double>(archive.size()));
    if (trial % 4 == 0) {
      damaged.resize(at);
    } else {
      damaged[at] = static_cast<char>(random.uniform() * 256.0);
    }
    try {
      LandmarkStore store = stores_from(damaged, 1)[0];
      EXPECT_EQ(items(store).size(), store.size());
      store.add(landmark_at(0.0, 0.0));
    } catch (const DataError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 500);  // at least those that were cut short
}

}  // namespace
}  // namespace waymark::feature_map
