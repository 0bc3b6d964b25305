// SPDX-License-Identifier: Apache-2.0
#include "monitoring/standstill.hpp"

#include <gtest/gtest.h>

namespace waymark {
namespace {

Time at(double s) { return Time{from_seconds(s)}; }

TEST(Standstill, LapsesWhenItsSensorBecomesSilent) {
  monitoring::Standstill standstill(1, from_seconds(0.5));
  for (int i = 0; i <= 10; ++i) standstill.report(0, at(0.1 * i), {.moving = false});
  EXPECT_TRUE(standstill.standing());
  EXPECT_FALSE(standstill.lapses(at(1.9)));
  EXPECT_TRUE(standstill.lapses(at(2.1)));
  EXPECT_FALSE(standstill.standing());
}

TEST(Standstill, LastsWhileAReportIsValidUntilTheSensorsNextOne) {
  monitoring::Standstill standstill(1, from_seconds(0.5));
  for (int i = 0; i <= 10; ++i) standstill.report(0, at(0.1 * i), {.moving = false, .until_next = true});
  EXPECT_FALSE(standstill.lapses(at(60.0)));
  EXPECT_TRUE(standstill.standing());
  standstill.report(0, at(60.0), {.moving = true, .until_next = true});
  EXPECT_FALSE(standstill.standing());
}

TEST(Standstill, NeedsASensorThatMeasuresTheVelocity) {
  monitoring::Standstill standstill(2, from_seconds(0.5));
  for (int i = 0; i <= 50; ++i) standstill.report(0, at(0.1 * i), {.moving = false, .measures_velocity = false});
  EXPECT_FALSE(standstill.standing());
  for (int i = 51; i <= 60; ++i) standstill.report(1, at(0.1 * i), {.moving = false});
  EXPECT_TRUE(standstill.standing());
}

}  // namespace
}  // namespace waymark
