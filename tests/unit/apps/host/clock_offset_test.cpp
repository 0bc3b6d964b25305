// SPDX-License-Identifier: Apache-2.0
#include "clock_offset.hpp"

#include <gtest/gtest.h>

#include "latency.hpp"
#include "waymark/math/random.hpp"

namespace waymark::host {
namespace {

Time at(double seconds) { return Time{} + from_seconds(seconds); }

/// Delays of 5 ms and more, a tail up to 55 ms.
double delay(int k) { return 0.005 + 0.05 * ((k * 37) % 100) / 100.0; }

TEST(ClockOffset, IsThatOfTheQuickestMeasurement) {
  ClockOffset clock;
  for (int k = 0; k < 600; ++k) clock.add(at(0.1 * k + 0.3), at(0.1 * k + delay(k)));
  EXPECT_NEAR(clock.offset_s(), 0.295, 1e-6);
  EXPECT_NEAR(clock.drift(), 0.0, 1e-6);
}

TEST(ClockOffset, FindsADriftingClock) {
  ClockOffset clock;
  constexpr double kDrift = 50e-6;
  for (int k = 0; k < 6000; ++k) {
    const double t = 0.1 * k;
    clock.add(at(t * (1.0 + kDrift)), at(t + delay(k)));
  }
  EXPECT_NEAR(clock.drift(), kDrift, 1e-6);
}

TEST(ClockOffset, OfStampsFiftyYearsAwayIsExactToMicroseconds) {
  ClockOffset clock;
  const Time epoch = at(1.7e9);
  for (int k = 0; k < 200; ++k) clock.add(at(0.1 * k), epoch + from_seconds(0.1 * k + 0.01));
  EXPECT_NEAR(clock.offset_s(), -1.7e9 - 0.01, 1e-5);
}

TEST(ClockOffset, WithoutMeasurementsIsZero) {
  const ClockOffset clock;
  EXPECT_EQ(clock.offset_s(), 0.0);
  EXPECT_EQ(clock.drift(), 0.0);
}

TEST(Latency, QuantilesAreExactToABin) {
  Latency latency;
  for (int k = 1; k <= 1000; ++k) latency.add(1e-3 * k);
  EXPECT_NEAR(latency.quantile(0.5), 0.5, 0.03);
  EXPECT_NEAR(latency.quantile(0.99), 0.99, 0.05);
  EXPECT_EQ(latency.max(), 1.0);
  EXPECT_EQ(latency.quantile(1.0), 1.0);
  EXPECT_EQ(latency.count(), 1000U);
}

TEST(Latency, TakesAnyValue) {
  Latency latency;
  EXPECT_EQ(latency.quantile(0.5), 0.0);
  latency.add(-1.0);
  latency.add(0.0);
  latency.add(1e9);
  EXPECT_EQ(latency.count(), 3U);
  EXPECT_EQ(latency.max(), 1e9);
}

}  // namespace
}  // namespace waymark::host
