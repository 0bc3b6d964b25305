// SPDX-License-Identifier: Apache-2.0
#include "waymark/base/time.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "waymark/base/error.hpp"

namespace waymark {
namespace {

std::int64_t nanoseconds(std::string_view text) { return parse_time(text).time_since_epoch().count(); }

TEST(ParseTime, IsExactWhereADoubleIsNot) {
  EXPECT_EQ(nanoseconds("1248272272.841000001"), 1248272272841000001);
  EXPECT_EQ(nanoseconds("4007199254.740993001"), 4007199254740993001);
}

TEST(ParseTime, ReadsSignsAndMissingParts) {
  EXPECT_EQ(nanoseconds("-0.5"), -500'000'000);
  EXPECT_EQ(nanoseconds("+2"), 2'000'000'000);
  EXPECT_EQ(nanoseconds(".25"), 250'000'000);
  EXPECT_EQ(nanoseconds("3."), 3'000'000'000);
  EXPECT_EQ(nanoseconds("-0"), 0);
  EXPECT_EQ(nanoseconds("0000000000000000000000000001.000"), 1'000'000'000);
}

TEST(ParseTime, ReadsExponents) {
  EXPECT_EQ(nanoseconds("1e-3"), 1'000'000);
  EXPECT_EQ(nanoseconds("1.2482722e9"), 1248272200000000000);
  EXPECT_EQ(nanoseconds("125E+1"), 1250'000'000'000);
  EXPECT_EQ(nanoseconds("0e999999999999999999"), 0);
  EXPECT_EQ(nanoseconds("1e-999999999999999999"), 0);
  EXPECT_EQ(nanoseconds("0.0000000000005e12"), 500'000'000);
}

TEST(ParseTime, RoundsBeyondTheNanosecond) {
  EXPECT_EQ(nanoseconds("0.0000000014"), 1);
  EXPECT_EQ(nanoseconds("0.0000000015"), 2);
  EXPECT_EQ(nanoseconds("-0.0000000015"), -2);
  EXPECT_EQ(nanoseconds("0.9999999999"), 1'000'000'000);
  EXPECT_EQ(nanoseconds("0.0000000005"), 1);
  EXPECT_EQ(nanoseconds("0.00000000049"), 0);
}

TEST(ParseTime, IgnoresBlanksAround) { EXPECT_EQ(nanoseconds(" \t1.5\r\n"), 1'500'000'000); }

TEST(ParseTime, ReachesBothEndsOfTheRange) {
  EXPECT_EQ(nanoseconds("4611686018.427387903"), kLongest.count());
  EXPECT_EQ(nanoseconds("-4611686018.427387903"), -kLongest.count());
  EXPECT_GT(parse_time("4611686018.427387903") - parse_time("-4611686018.427387903"), Duration::zero());
}

TEST(ParseTime, RefusesWhatLeavesTheRange) {
  for (const char* text :
       {"4611686018.427387904", "-4611686018.427387904", "9223372036.854775808", "-9223372036.854775809", "1e10",
        "1e300", "123456789012345678901234567890", "1e99999999999999999999"}) {
    EXPECT_THROW(parse_time(text), DataError) << text;
  }
}

TEST(ParseTime, RefusesWhatIsNoNumber) {
  for (const char* text : {"", " ", "nan", "inf", "-inf", "abc", "1.2.3", "1e", "1e+", "1 2", "--1", "+-1", ".", "-",
                           "0x10", "1,5", "1s"}) {
    EXPECT_THROW(parse_time(text), DataError) << text;
  }
}

TEST(ParseTime, QuotesTheText) {
  try {
    parse_time("12:30");
    FAIL();
  } catch (const DataError& error) {
    EXPECT_NE(std::string(error.what()).find("\"12:30\""), std::string::npos) << error.what();
  }
}

TEST(Time, IsWrittenWithFewerDigitsRounded) {
  const Time stamp{Duration{1777640429070499999}};
  EXPECT_EQ(format_time(stamp, 3), "1777640429.070");
  EXPECT_EQ(format_time(stamp, 4), "1777640429.0705");
  EXPECT_EQ(format_time(stamp, 0), "1777640429");
  EXPECT_EQ(format_time(stamp, 9), format_time(stamp));
  EXPECT_EQ(format_time(Time{Duration{-1500600000}}, 3), "-1.501");
  EXPECT_EQ(format_time(Time{Duration{999999999}}, 3), "1.000");
}

TEST(FormatTime, IsTheInverse) {
  EXPECT_EQ(format_time(Time{}), "0.000000000");
  EXPECT_EQ(format_time(Time{Duration{-1}}), "-0.000000001");
  for (const std::int64_t count : {std::int64_t{0}, std::int64_t{-500'000'000}, std::int64_t{1248272272841000001},
                                   kLongest.count(), -kLongest.count()}) {
    const Time time{Duration{count}};
    EXPECT_EQ(parse_time(format_time(time)), time);
  }
}

TEST(FromSeconds, RoundsToTheNearest) {
  EXPECT_EQ(from_seconds(0.1).count(), 100'000'000);
  EXPECT_EQ(from_seconds(-0.1).count(), -100'000'000);
  EXPECT_DOUBLE_EQ(to_seconds(from_seconds(12.345678901)), 12.345678901);
}

TEST(FromSeconds, ALimitTooLongToCountIsNeverReached) {
  for (const double seconds : {4.7e9, 9.3e9, 1e12, 1e300, HUGE_VAL, std::nan("")}) {
    EXPECT_EQ(from_seconds(seconds), kLongest) << seconds;
  }
  for (const double seconds : {-4.7e9, -1e12, -HUGE_VAL}) EXPECT_EQ(from_seconds(seconds), -kLongest) << seconds;
}

TEST(FromSeconds, TwoLimitsAndAStampCanBeAdded) {
  const Duration never = from_seconds(1e12);
  EXPECT_GT(never + never, never);
  EXPECT_GT(Time{kLongest} + never, Time{kLongest});
  EXPECT_LT(Time{-kLongest} - never, Time{-kLongest});
}

TEST(Moved, IsNothingBeyondTheRangeOfStamps) {
  EXPECT_EQ(moved(Time{}, kLongest), Time{kLongest});
  EXPECT_EQ(moved(Time{kLongest}, Duration{1}), std::nullopt);
  EXPECT_EQ(moved(Time{-kLongest}, Duration{-1}), std::nullopt);
  EXPECT_EQ(moved(Time::max(), Duration::max()), std::nullopt);
  EXPECT_EQ(moved(Time::min(), Duration::min()), std::nullopt);
}

TEST(StampOn, CountsFromMidnightAndRefusesYearsBeyondTheRange) {
  using namespace std::chrono_literals;  // NOLINT(google-build-using-namespace): years and days
  EXPECT_EQ(stamp_on(2024y / 12 / 31, 25h), parse_time("1735693200"));
  EXPECT_NE(stamp_on(1824y / 1 / 1, 0h), std::nullopt);
  EXPECT_NE(stamp_on(2115y / 12 / 31, 24h), std::nullopt);
  for (const int year : {-9999, 0, 1677, 1800, 2200, 2300, 9999})
    EXPECT_EQ(stamp_on(std::chrono::year(year) / 1 / 1, 0h), std::nullopt) << year;
}

TEST(StampAfter, RefusesWhatIsBeyondTheRange) {
  EXPECT_EQ(stamp_after(7, from_seconds(0.1)), parse_time("0.7"));
  EXPECT_EQ(stamp_after(std::numeric_limits<std::uint64_t>::max(), from_seconds(0.1)), std::nullopt);
  EXPECT_EQ(stamp_after(20110926130225, from_seconds(0.1)), std::nullopt);
}

}  // namespace
}  // namespace waymark
