// SPDX-License-Identifier: Apache-2.0
#include "plugins/shared/run_views/titles.hpp"

#include <gtest/gtest.h>

namespace waymark::run_views {
namespace {

TEST(Titles, AStandardDeviationIsNeverRoundedToZero) {
  EXPECT_EQ(sigma_text(0.0042), "0.0042");
  EXPECT_EQ(sigma_text(0.11), "0.11");
  EXPECT_EQ(sigma_text(12.3), "12");
  EXPECT_EQ(sigma_text(0.0), "0.00");
}

TEST(Titles, AValueHasTheDecimalsOfItsStandardDeviation) {
  EXPECT_EQ(value_text(12.34, 0.0042), "12.3400 ± 0.0042");
  EXPECT_EQ(value_text(-3.14159, 12.3), "-3 ± 12");
}

TEST(Titles, AStampThatDoesNotCountFrom1970HasNoDate) {
  EXPECT_EQ(date_text(Time{from_seconds(12.0)}), "");
  EXPECT_EQ(date_text(Time{from_seconds(1317042120.0)}), "2011-09-26 13:02 UTC");
}

TEST(Titles, ADurationIsInTheUnitsOfItsSize) {
  EXPECT_EQ(duration_text(9.64), "9.6 s");
  EXPECT_EQ(duration_text(170.0), "2 min 50 s");
  EXPECT_EQ(duration_text(3900.0), "1 h 05 min");
  EXPECT_EQ(duration_text(200'000.0), "2 d 07 h");
}

}  // namespace
}  // namespace waymark::run_views
