// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/command/folded_events.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace waymark::command {
namespace {

using ::testing::ElementsAre;

Event event(double t, std::string text) { return {std::move(text), Time{from_seconds(t)}, false}; }

std::vector<std::string> lines_of(const std::vector<Event>& events) {
  std::vector<std::string> lines;
  for (const FoldedEvents& folded : fold(events)) {
    for (std::string& line : folded.lines()) lines.push_back(std::move(line));
  }
  return lines;
}

TEST(FoldedEvents, OnesThatDifferInNumbersOnlyAreFolded) {
  std::vector<Event> events;
  for (int k = 0; k < 308; ++k)
    events.push_back(
        event(10.0 + k, fmt::format("gps: 20 measurements in a row rejected, the last one by {:.3g} m", 0.1 + k)));
  EXPECT_THAT(lines_of(events),
              ElementsAre("at 10.000 s: gps: 20 measurements in a row rejected, the last one by 0.1 m",
                          "  308 times until 317.000 s; the last: gps: 20 measurements in a row rejected, the last one "
                          "by 307 m"));
}

TEST(FoldedEvents, EqualOnesAreNotRepeated) {
  EXPECT_THAT(lines_of({event(1.0, "closed"), event(2.5, "closed")}),
              ElementsAre("at 1.000 s: closed", "  2 times until 2.500 s"));
}

TEST(FoldedEvents, TwoSensorsAreTwoKinds) {
  EXPECT_THAT(
      lines_of({event(1.0, "gps1: off by 2 m"), event(2.0, "gps2: off by 2 m"), event(3.0, "gps1: off by 4 m")}),
      ElementsAre("at 1.000 s: gps1: off by 2 m", "  2 times until 3.000 s; the last: gps1: off by 4 m",
                  "at 2.000 s: gps2: off by 2 m"));
}

TEST(FoldedEvents, SignsAndExponentsArePartOfANumber) {
  EXPECT_EQ(without_numbers("by -1.5e-07 m at 12.5, twice"), "by # m at #, twice");
  EXPECT_EQ(without_numbers("by 3 m at 7, twice"), "by # m at #, twice");
  EXPECT_EQ(without_numbers("wheel_2: 3 of 4."), "wheel_2: # of #.");
}

TEST(FoldedEvents, StampsOfTheSystemsClockAreExact) {
  EXPECT_THAT(lines_of({{"closed", Time{Duration{1777640429070499999}}, false}}),
              ElementsAre("at 1777640429.070 s: closed"));
}

TEST(RepeatedEvents, AreShownThriceAndThenEverMoreSeldom) {
  RepeatedEvents repeated;
  std::vector<std::uint64_t> shown;
  for (int k = 0; k < 1500; ++k) {
    std::uint64_t count = 0;
    if (repeated.shows(event(k, fmt::format("lost {} packets", k)), count)) shown.push_back(count);
  }
  EXPECT_THAT(shown, ElementsAre(1, 2, 3, 10, 100, 1000));
}

}  // namespace
}  // namespace waymark::command
