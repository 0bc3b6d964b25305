// SPDX-License-Identifier: Apache-2.0
#include "fusion/new_events.hpp"

#include <gmock/gmock.h>

#include <string>
#include <vector>

namespace waymark::fusion {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

Event event(const std::string& text, double t) { return {text, Time{} + from_seconds(t)}; }

std::vector<std::string> taken(NewEvents& fresh, const std::vector<Event>& events) {
  std::vector<Event> out;
  fresh.take(events, out);
  std::vector<std::string> texts;
  for (const Event& one : out) texts.push_back(one.text);
  return texts;
}

TEST(NewEvents, EachComesOnce) {
  NewEvents fresh;
  std::vector<Event> events{event("a", 1.0), event("b", 2.0)};
  EXPECT_THAT(taken(fresh, events), ElementsAre("a", "b"));
  EXPECT_THAT(taken(fresh, events), IsEmpty());
  events.push_back(event("b", 3.0));
  EXPECT_THAT(taken(fresh, events), ElementsAre("b"));
}

TEST(NewEvents, WhatARollbackRepeatsIsNotNew) {
  NewEvents fresh;
  std::vector<Event> events{event("a", 1.0), event("b", 2.0), event("c", 3.0)};
  taken(fresh, events);
  fresh.roll_back(events, 1);
  events.resize(1);
  for (const Event& repeated : {event("b", 2.0), event("late", 2.5), event("c", 3.0)}) events.push_back(repeated);
  EXPECT_THAT(taken(fresh, events), ElementsAre("late"));
}

TEST(NewEvents, ARollbackOfWhatNobodyTookHidesNothing) {
  NewEvents fresh;
  std::vector<Event> events{event("a", 1.0), event("b", 2.0)};
  fresh.roll_back(events, 1);
  EXPECT_THAT(taken(fresh, events), ElementsAre("a", "b"));
}

TEST(NewEvents, SkipLeavesOutWhatThereIs) {
  NewEvents fresh;
  std::vector<Event> events{event("a", 1.0)};
  fresh.skip(events);
  events.push_back(event("b", 2.0));
  EXPECT_THAT(taken(fresh, events), ElementsAre("b"));
}

}  // namespace
}  // namespace waymark::fusion
