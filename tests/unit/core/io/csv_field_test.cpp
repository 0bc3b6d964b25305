// SPDX-License-Identifier: Apache-2.0
#include "waymark/io/csv_field.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace waymark {
namespace {

TEST(CsvField, LeavesAPlainTextAsItIs) {
  EXPECT_EQ(csv_field(""), "");
  EXPECT_EQ(csv_field("gps 1; rear"), "gps 1; rear");
}

TEST(CsvField, QuotesWhatWouldTearARow) {
  EXPECT_EQ(csv_field("a,b"), "\"a,b\"");
  EXPECT_EQ(csv_field("a\nb"), "\"a\nb\"");
  EXPECT_EQ(csv_field("a\rb"), "\"a\rb\"");
  EXPECT_EQ(csv_field("5\" scanner"), "\"5\"\" scanner\"");
}

TEST(CsvField, LeavesAnUnknownNumberEmpty) {
  EXPECT_EQ(csv_field(-1.5, 3), "-1.500");
  EXPECT_EQ(csv_field(std::numeric_limits<double>::quiet_NaN(), 3), "");
  EXPECT_EQ(csv_field(-std::numeric_limits<double>::infinity(), 3), "");
}

}  // namespace
}  // namespace waymark
