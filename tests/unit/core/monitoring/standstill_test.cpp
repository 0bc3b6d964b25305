// SPDX-License-Identifier: Apache-2.0
#include "monitoring/standstill.hpp"

#include <gtest/gtest.h>

namespace waymark {
namespace {

Time at(double s) { return Time{from_seconds(s)}; }

TEST(Standstill, LapsesWhenItsSensorBecomesSilent) {
  monitoring::Standstill standstill(1, from_seconds(0.5));
  for (int i = 0; i <= 10; ++i) standstill.report(0, at(0.1 * i), false);
  EXPECT_TRUE(standstill.standing());
  EXPECT_FALSE(standstill.lapses(at(1.9)));
  EXPECT_TRUE(standstill.lapses(at(2.1)));
  EXPECT_FALSE(standstill.standing());
}

TEST(Standstill, LastsWhileAReportIsValidUntilTheSensorsNextOne) {
  monitoring::Standstill standstill(1, from_seconds(0.5));
  for (int i = 0; i <= 10; ++i) standstill.report(0, at(0.1 * i), false, true);
  EXPECT_FALSE(standstill.lapses(at(60.0)));
  EXPECT_TRUE(standstill.standing());
  standstill.report(0, at(60.0), true, true);
  EXPECT_FALSE(standstill.standing());
}

}  // namespace
}  // namespace waymark
