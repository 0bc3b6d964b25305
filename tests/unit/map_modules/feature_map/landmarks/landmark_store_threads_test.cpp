// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <sstream>
#include <thread>

#include "tests/unit/map_modules/feature_map/feature_map_bench.hpp"
#include "waymark/math/random.hpp"

namespace waymark::feature_map {
namespace {

using feature_map_test::landmark_at;

std::string bytes_of(const LandmarkStore& store) {
  std::ostringstream stream;
  OutArchive out(stream);
  store.save(out);
  return stream.str();
}

/// Writes, erases, adds and copies by the numbers of one stream.
LandmarkStore worked_on(LandmarkStore store, std::uint32_t slot) {
  Random random({.seed = 1, .slot = slot, .stamp = 0, .sensor = 0});
  for (int round = 0; round < 300; ++round) {
    std::vector<LandmarkRef> refs;
    store.for_near({0.0, 0.0}, 1e6, [&](LandmarkRef ref, const Landmark&) { refs.push_back(ref); });
    const LandmarkRef ref = refs[static_cast<std::size_t>(random.uniform() * static_cast<double>(refs.size()))];
    const LandmarkStore copy = store;  // an ancestor that is still alive
    if (round % 7 == 0) {
      store.erase(ref);
      store.add(landmark_at(20.0 * random.normal(), 20.0 * random.normal()));
    } else {
      Landmark landmark = store.at(ref);
      landmark.mean.x() += 0.1 * random.normal();
      store.write(ref, landmark);
    }
    if (round % 50 == 49) store = copy;
  }
  return store;
}

TEST(LandmarkStoreThreads, ClonesWrittenByManyThreadsAreAsIfWrittenByOne) {
  LandmarkStore family;
  for (int i = 0; i < 120; ++i) family.add(landmark_at(i % 11 * 8.0, i / 11 * 8.0));
  const std::string before = bytes_of(family);

  constexpr std::uint32_t kThreads = 4;
  std::vector<LandmarkStore> results(kThreads, family);
  std::vector<std::thread> threads;
  for (std::uint32_t t = 0; t < kThreads; ++t) {
    threads.emplace_back([&results, t] { results[t] = worked_on(results[t], t); });
  }
  for (std::thread& thread : threads) thread.join();

  for (std::uint32_t t = 0; t < kThreads; ++t) EXPECT_EQ(bytes_of(results[t]), bytes_of(worked_on(family, t))) << t;
  EXPECT_EQ(bytes_of(family), before);
}

}  // namespace
}  // namespace waymark::feature_map
