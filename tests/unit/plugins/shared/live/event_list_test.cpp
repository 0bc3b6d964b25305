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
  for (std::size_t i = 0; i < EventList::kMost + 7; ++i) events.add("connected");
  const std::vector<std::string> taken = events.take();
  ASSERT_EQ(taken.size(), EventList::kMost + 1);
  EXPECT_EQ(taken.back(), "7 more events");
  events.add("lost");
  EXPECT_THAT(events.take(), ElementsAre("lost"));
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
