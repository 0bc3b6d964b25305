// SPDX-License-Identifier: Apache-2.0
#include "waymark/base/time.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "waymark/base/error.hpp"

namespace waymark {
namespace {

std::int64_t nanoseconds(std::string_view text) { return parse_time(text).time_since_epoch().count(); }

TEST(ParseTime, IsExactWhereADoubleIsNot) {
  EXPECT_EQ(nanoseconds("1248272272.841000001"), 1248272272841000001);
  EXPECT_EQ(nanoseconds("9007199254.740993001"), 9007199254740993001);
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
  EXPECT_EQ(nanoseconds("9223372036.854775807"), std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(nanoseconds("-9223372036.854775808"), std::numeric_limits<std::int64_t>::min());
}

TEST(ParseTime, RefusesWhatLeavesTheRange) {
  for (const char* text : {"9223372036.854775808", "-9223372036.854775809", "1e10", "1e300",
                           "123456789012345678901234567890", "1e99999999999999999999"}) {
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

TEST(FormatTime, IsTheInverse) {
  EXPECT_EQ(format_time(Time{}), "0.000000000");
  EXPECT_EQ(format_time(Time{Duration{-1}}), "-0.000000001");
  for (const std::int64_t count :
       {std::int64_t{0}, std::int64_t{-500'000'000}, std::int64_t{1248272272841000001},
        std::numeric_limits<std::int64_t>::max(), std::numeric_limits<std::int64_t>::min()}) {
    const Time time{Duration{count}};
    EXPECT_EQ(parse_time(format_time(time)), time);
  }
}

TEST(FromSeconds, RoundsToTheNearest) {
  EXPECT_EQ(from_seconds(0.1).count(), 100'000'000);
  EXPECT_EQ(from_seconds(-0.1).count(), -100'000'000);
  EXPECT_DOUBLE_EQ(to_seconds(from_seconds(12.345678901)), 12.345678901);
}

}  // namespace
}  // namespace waymark
