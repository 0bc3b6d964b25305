// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/live/event_list.hpp"

#include <gmock/gmock.h>

#include "plugins/shared/live/back_off.hpp"

namespace waymark::live {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(EventList, GivesEveryEventOnce) {
  EventList events;
  events.add("connected");
  events.add("lost");
  EXPECT_THAT(events.take(), ElementsAre("connected", "lost"));
  EXPECT_THAT(events.take(), IsEmpty());
}

TEST(EventList, CountsWhatNobodyTakes) {
  EventList events;
  const auto now = EventList::Clock::now();
  for (std::size_t i = 0; i < EventList::kMost + 7; ++i) events.add("connected", now);
  const std::vector<std::string> taken = events.take(now);
  ASSERT_EQ(taken.size(), EventList::kMost + 1);
  EXPECT_EQ(taken.back(), "7 more events");
  events.add("lost", now + std::chrono::seconds(1));
  EXPECT_THAT(events.take(now + std::chrono::seconds(1)), ElementsAre("lost"));
}

TEST(EventList, AreFewOfAPeerThatComesAndGoesHoweverOftenTheyAreTaken) {
  EventList events;
  std::size_t taken = 0;
  constexpr int kSeconds = 60;
  constexpr int kASecond = 1000;
  auto now = EventList::Clock::now();
  for (int i = 0; i < kSeconds * kASecond; ++i) {
    now += std::chrono::milliseconds(1000 / kASecond);
    events.add("connected", now);
    taken += events.take(now).size();
  }
  EXPECT_GT(taken, EventList::kMost);
  EXPECT_LT(taken, EventList::kMost + 6U * kSeconds);
}

TEST(BackOff, DoublesUpToFiveSeconds) {
  using std::chrono::milliseconds;
  BackOff back_off;
  EXPECT_EQ(back_off.next(), milliseconds(100));
  EXPECT_EQ(back_off.next(), milliseconds(200));
  for (int i = 0; i < 10; ++i) back_off.next();
  EXPECT_EQ(back_off.next(), milliseconds(5000));
  back_off.reset();
  EXPECT_EQ(back_off.next(), milliseconds(100));
}

}  // namespace
}  // namespace waymark::live
