// SPDX-License-Identifier: Apache-2.0
#include "gap_watch.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <vector>

#include "clock_offset.hpp"
#include "waymark/math/random.hpp"

namespace waymark::host {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

constexpr double kDelay = 0.01;  // of each measurement [s]

Time at(double seconds) { return Time{} + from_seconds(seconds); }

/// A sensor whose gaps are looked for as in a running robot.
struct Sensor {
  GapWatch watch;
  ClockOffset clock;
  std::vector<Gap> gaps;

  void add(double stamp_s, double arrival_s) {
    const auto best = clock.best_offset();
    if (const auto gap = watch.add(at(stamp_s), at(stamp_s) - at(arrival_s), best)) gaps.push_back(*gap);
    clock.add(at(stamp_s), at(arrival_s));
  }
  /// Measurements with a period, from `from` to `to` without it.
  void run(double from, double to, double period) {
    const auto count = static_cast<int>(std::lround((to - from) / period));
    for (int k = 0; k < count; ++k) add(from + period * k, from + period * k + kDelay);
  }
};

TEST(GapWatch, FindsWhatASteadySensorLost) {
  for (const double period : {0.005, 0.02, 0.2, 1.0}) {
    Sensor sensor;
    sensor.run(0.0, 20.0, period);
    sensor.run(30.0, 50.0, period);
    ASSERT_THAT(sensor.gaps, SizeIs(1)) << period;
    const auto lost = static_cast<std::uint64_t>(std::lround(10.0 / period));
    EXPECT_EQ(sensor.gaps[0].missing, lost);
    EXPECT_EQ(sensor.watch.missing(), lost);
    EXPECT_EQ(sensor.gaps[0].count, 1U);
    EXPECT_NEAR(sensor.gaps[0].longest_s, 10.0 + period, 1e-6);
    EXPECT_NEAR(sensor.gaps[0].period_s, period, 1e-6);
  }
}

TEST(GapWatch, DescribesAGap) {
  EXPECT_EQ(describe({9.8049, 0.005, 1960, 1}), "no measurement for 9.8 s (period 0.005 s): some 1960 missing");
  EXPECT_EQ(describe({0.52, 0.02, 61, 3}),
            "3 gaps, the longest of 0.52 s without a measurement (period 0.02 s): some 61 missing");
}

/// A program that is stopped for 10 s reads what the system kept of them, the first 2 s, then what comes.
TEST(GapWatch, FindsWhatWasLostWhileTheProgramWasStopped) {
  Sensor sensor;
  sensor.run(0.0, 10.0, 0.02);
  for (int k = 0; k < 100; ++k) sensor.add(10.0 + 0.02 * k, 20.0);
  EXPECT_THAT(sensor.gaps, IsEmpty());
  sensor.run(20.0, 25.0, 0.02);
  ASSERT_THAT(sensor.gaps, SizeIs(1));
  EXPECT_EQ(sensor.gaps[0].missing, 400U);
}

TEST(GapWatch, NothingIsMissingIfAllOfItComesLate) {
  Sensor sensor;
  sensor.run(0.0, 10.0, 0.02);
  for (int k = 0; k < 500; ++k) sensor.add(10.0 + 0.02 * k, 20.0);
  sensor.run(20.0, 25.0, 0.02);
  EXPECT_THAT(sensor.gaps, IsEmpty());
}

TEST(GapWatch, NothingIsMissingIfABurstIsStampedOnReception) {
  Sensor sensor;
  sensor.run(0.0, 10.0, 0.005);
  for (int k = 0; k < 2000; ++k) {
    const double stamp = 20.0 + 0.001 * (k / 100);  // of a clock that counts milliseconds
    sensor.add(stamp, stamp);
  }
  sensor.run(20.025, 25.0, 0.005);
  EXPECT_THAT(sensor.gaps, IsEmpty());
  EXPECT_EQ(sensor.watch.missing(), 0U);
}

TEST(GapWatch, SeveralGapsAtOnceAreOne) {
  Sensor sensor;
  sensor.run(0.0, 10.0, 0.02);
  for (int gap = 0; gap < 4; ++gap) sensor.run(10.0 + 0.5 * gap, 10.2 + 0.5 * gap, 0.02);
  sensor.run(12.0, 20.0, 0.02);
  ASSERT_THAT(sensor.gaps, SizeIs(1));
  EXPECT_EQ(sensor.gaps[0].count, 4U);
  EXPECT_EQ(sensor.gaps[0].missing, 60U);
  EXPECT_NEAR(sensor.gaps[0].longest_s, 0.32, 1e-6);
}

TEST(GapWatch, AnotherRateIsNoGap) {
  Sensor sensor;
  sensor.run(0.0, 10.0, 0.005);
  sensor.run(10.0, 60.0, 0.1);
  EXPECT_THAT(sensor.gaps, IsEmpty());
  sensor.run(70.0, 80.0, 0.1);
  ASSERT_THAT(sensor.gaps, SizeIs(1));
  EXPECT_EQ(sensor.gaps[0].missing, 100U);
}

TEST(GapWatch, ASensorWithoutASteadyPeriodIsNotWatched) {
  Random random({7, 0, 0, 0});
  Sensor events;
  double t = 0.0;
  for (int k = 0; k < 5000; ++k) {
    t += -0.1 * std::log(1.0 - random.uniform());
    events.add(t, t + kDelay);
  }
  EXPECT_THAT(events.gaps, IsEmpty()) << "at random";

  Sensor bursts;
  for (int k = 0; k < 500; ++k) bursts.run(2.0 * k, 2.0 * k + 0.1, 0.02);
  EXPECT_THAT(bursts.gaps, IsEmpty()) << "five at a time";
}

TEST(GapWatch, ASensorThatBeginsToPauseIsReportedAFewTimes) {
  Sensor sensor;
  sensor.run(0.0, 10.0, 0.02);
  for (int k = 0; k < 500; ++k) sensor.run(10.0 + 2.0 * k, 10.1 + 2.0 * k, 0.02);
  EXPECT_THAT(sensor.gaps, SizeIs(testing::AllOf(testing::Ge(1), testing::Le(10))));
}

TEST(GapWatch, JitterAndMeasurementsOutOfOrderAreNoGap) {
  Random random({3, 0, 0, 0});
  Sensor sensor;
  for (int k = 0; k < 20000; ++k) {
    const double t = 0.005 * k + 0.004 * random.uniform() - (k % 7 == 0 ? 0.006 : 0.0);
    sensor.add(t, 0.005 * k + 0.02 * random.uniform());
  }
  EXPECT_THAT(sensor.gaps, IsEmpty());
}

TEST(GapWatch, AClockThatIsSetIsNoGap) {
  for (const double step : {-3600.0, -1.0, 1.0, 1.9, 3600.0}) {
    Sensor sensor;
    sensor.run(0.0, 10.0, 0.02);
    for (int k = 0; k < 500; ++k) sensor.add(10.0 + 0.02 * k + step, 10.0 + 0.02 * k + kDelay);
    EXPECT_THAT(sensor.gaps, IsEmpty()) << step;
  }
}

TEST(GapWatch, AClockOfUnknownOffsetAndABreakAreNoGap) {
  GapWatch watch;
  for (int k = 0; k < 100; ++k) EXPECT_FALSE(watch.add(at(0.02 * k), Duration::zero(), Duration::zero()));
  for (int k = 0; k < 100; ++k) EXPECT_FALSE(watch.add(at(10.0 + 0.02 * k), Duration::zero(), std::nullopt));
  watch.break_off();
  for (int k = 0; k < 100; ++k) EXPECT_FALSE(watch.add(at(20.0 + 0.02 * k), Duration::zero(), Duration::zero()));
}

}  // namespace
}  // namespace waymark::host
