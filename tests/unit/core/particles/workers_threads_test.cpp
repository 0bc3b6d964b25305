// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <set>
#include <thread>
#include <vector>

#include "particles/workers.hpp"

namespace waymark {
namespace {

class WorkersThreads : public ::testing::TestWithParam<int> {
 protected:
  particles::Workers workers_{GetParam()};
};

TEST_P(WorkersThreads, EveryIndexIsVisitedOnce) {
  for (const int count : {0, 1, 2, 3, 7, 8, 9, 64, 101}) {
    std::vector<int> visits(static_cast<std::size_t>(count), 0);
    workers_.for_each(
        count, [&](int i) { ++visits[static_cast<std::size_t>(i)]; }, 2);
    EXPECT_EQ(visits, std::vector<int>(static_cast<std::size_t>(count), 1));
  }
}

TEST_P(WorkersThreads, ACallReturnsWhenAllPartsAreDone) {
  // Plain ints: a call that returned early would be a data race, and the sum would be wrong.
  std::vector<int> values(100, 0);
  for (int round = 0; round < 2000; ++round) {
    workers_.for_each(
        100, [&](int i) { values[static_cast<std::size_t>(i)] += i; }, 2);
    ASSERT_EQ(values[99], 99 * (round + 1));
    ASSERT_EQ(values[0] + values[50], 50 * (round + 1));
  }
}

TEST_P(WorkersThreads, OnePhaseSeesAllOfThePhaseBefore) {
  constexpr int kCount = 97;
  std::vector<long> now(kCount, 1);
  std::vector<long> next(kCount, 0);
  for (int round = 0; round < 300; ++round) {
    workers_.for_each(
        kCount,
        [&](int i) {
          next[static_cast<std::size_t>(i)] = (now[static_cast<std::size_t>((i + 1) % kCount)] + i) % 1009;
        },
        2);
    workers_.for_each(
        kCount, [&](int i) { now[static_cast<std::size_t>(i)] = next[static_cast<std::size_t>((i + 41) % kCount)]; },
        2);
  }
  std::vector<long> expected(kCount, 1);
  for (int round = 0; round < 300; ++round) {
    std::vector<long> step(kCount);
    for (std::size_t i = 0; i < kCount; ++i) step[i] = (expected[(i + 1) % kCount] + static_cast<long>(i)) % 1009;
    for (std::size_t i = 0; i < kCount; ++i) expected[i] = step[(i + 41) % kCount];
  }
  EXPECT_EQ(now, expected);
}

TEST_P(WorkersThreads, ShortLoopsStayWithTheCaller) {
  std::set<std::thread::id> seen;
  workers_.for_each(
      5, [&](int) { seen.insert(std::this_thread::get_id()); }, 6);
  EXPECT_EQ(seen, std::set<std::thread::id>{std::this_thread::get_id()});
}

TEST_P(WorkersThreads, AThreadWithALongPartKeepsNoOtherFromTheRest) {
  if (GetParam() == 1) return;  // there is no other
  const int count = 4 * GetParam();
  std::atomic<int> others{0};
  bool rest_was_done = false;
  workers_.for_each(
      count,
      [&](int i) {
        if (i != 0) {
          ++others;
          return;
        }
        const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(20);
        while (others < count - 1 && std::chrono::steady_clock::now() < give_up) std::this_thread::yield();
        rest_was_done = others == count - 1;
      },
      2);
  EXPECT_TRUE(rest_was_done);
}

INSTANTIATE_TEST_SUITE_P(Threads, WorkersThreads, ::testing::Values(1, 2, 3, 4));

TEST(Workers, ComeAndGoWithoutWork) {
  for (int i = 0; i < 50; ++i) EXPECT_EQ(particles::Workers(3).threads(), 3);
}

}  // namespace
}  // namespace waymark
