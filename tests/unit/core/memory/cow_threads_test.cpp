// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <atomic>
#include <optional>
#include <thread>
#include <vector>

#include "waymark/memory/cow.hpp"

namespace waymark {
namespace {

/// Counts the objects that are alive and the copies that were made.
struct Counted {
  static std::atomic<int> alive;
  static std::atomic<int> copies;
  std::vector<int> data = std::vector<int>(64, 0);

  Counted() { ++alive; }
  Counted(const Counted& other) : data(other.data) {
    ++alive;
    ++copies;
  }
  Counted(Counted&& other) noexcept : data(std::move(other.data)) { ++alive; }
  Counted& operator=(const Counted&) = default;
  Counted& operator=(Counted&&) = default;
  ~Counted() { --alive; }
};
std::atomic<int> Counted::alive = 0;
std::atomic<int> Counted::copies = 0;

class CowThreads : public ::testing::Test {
 protected:
  CowThreads() {
    Counted::alive = 0;
    Counted::copies = 0;
  }
  template <class Body>
  static void in_parallel(int threads, const Body& body) {
    std::vector<std::thread> team;
    for (int i = 0; i < threads; ++i) team.emplace_back([&body, i] { body(i); });
    for (std::thread& thread : team) thread.join();
  }
};

TEST_F(CowThreads, ASoleOwnerWritesInPlace) {
  Cow<Counted> cow;
  const void* identity = cow.identity();
  cow.write().data[0] = 7;
  EXPECT_EQ(cow.identity(), identity);
  EXPECT_EQ(Counted::copies, 0);
}

TEST_F(CowThreads, WritingASharedValueLeavesTheOtherAlone) {
  Cow<Counted> a;
  Cow<Counted> b = a;
  EXPECT_TRUE(a.shares_with(b));
  b.write().data[0] = 7;
  EXPECT_FALSE(a.shares_with(b));
  EXPECT_EQ(a->data[0], 0);
  EXPECT_EQ(b->data[0], 7);
  EXPECT_EQ(Counted::copies, 1);
}

TEST_F(CowThreads, AssignmentAndMoveKeepTheCountRight) {
  {
    Cow<Counted> a;
    Cow<Counted> b;
    b = a;
    EXPECT_EQ(Counted::alive, 1);
    const Cow<Counted>& same = b;
    b = same;
    Cow<Counted> c = std::move(a);
    a = b;
    b = Cow<Counted>();
    c.write();
    EXPECT_EQ(Counted::alive, 3);
  }
  EXPECT_EQ(Counted::alive, 0);
}

TEST_F(CowThreads, HandlesOfOneValueAreWrittenFromManyThreads) {
  constexpr int kThreads = 4;
  for (int round = 0; round < 500; ++round) {
    std::vector<Cow<Counted>> handles(kThreads, Cow<Counted>());
    in_parallel(kThreads, [&](int i) {
      Cow<Counted>& mine = handles[static_cast<std::size_t>(i)];
      for (int& x : mine.write().data) x = i;
    });
    for (int i = 0; i < kThreads; ++i) EXPECT_EQ(handles[static_cast<std::size_t>(i)]->data, std::vector<int>(64, i));
    // The last one to come may find itself alone and write in place; more clones than handles there cannot be.
    EXPECT_EQ(Counted::alive, kThreads);
  }
  EXPECT_EQ(Counted::alive, 0);
}

TEST_F(CowThreads, ReadingAndWritingHandlesDoNotDisturbEachOther) {
  Cow<Counted> original;
  original.write().data.assign(64, 42);
  std::vector<Cow<Counted>> handles(4, original);
  std::atomic<int> wrong = 0;
  in_parallel(4, [&](int i) {
    Cow<Counted>& mine = handles[static_cast<std::size_t>(i)];
    for (int k = 0; k < 2000; ++k) {
      if (i % 2 == 0) {
        for (const int x : mine->data) wrong += x == 42 ? 0 : 1;
      } else {
        mine = Cow<Counted>(handles[static_cast<std::size_t>(i)]);
        mine.write().data[0] = 42;
      }
    }
  });
  EXPECT_EQ(wrong, 0);
}

TEST_F(CowThreads, CopiesComingAndGoingInManyThreadsLeaveExactlyOneObject) {
  Cow<Counted> original;
  std::vector<Cow<Counted>> seeds(4, original);
  in_parallel(4, [&](int i) {
    for (int k = 0; k < 5000; ++k) {
      std::vector<Cow<Counted>> copies(3, seeds[static_cast<std::size_t>(i)]);
      if (k % 50 == 0) copies[0].write().data[0] = k;
    }
  });
  EXPECT_EQ(Counted::alive, 1);
  seeds.clear();
  const void* identity = original.identity();
  original.write();
  EXPECT_EQ(original.identity(), identity) << "the count did not return to one";
}

}  // namespace
}  // namespace waymark
