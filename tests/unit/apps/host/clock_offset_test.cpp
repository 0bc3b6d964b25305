// SPDX-License-Identifier: Apache-2.0
#include "clock_offset.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "clock_steps.hpp"
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

/// A sensor of 20 Hz whose measurements pass through ClockSteps, as in a running robot.
struct Watched {
  ClockOffset clock;
  ClockSteps steps;
  UsableOffsets usable;
  double worst_s = 0.0;  // difference of a stamp from the true time, of those that are not uncertain
  int doubtful = 0;

  /// Adds those of `from` to `to` seconds; their clock is fast by `fast_s`, and they take `delay_s` more than usual.
  void add(double from, double to, double fast_s, double more_delay_s = 0.0) {
    for (double t = from; t < to; t += 0.05) {
      const Time arrival = at(t + delay(static_cast<int>(20.0 * t)) + more_delay_s);
      const Time stamp = steps.corrected(at(t + fast_s), arrival, clock.best_offset(usable), usable);
      if (steps.in_doubt()) {
        ++doubtful;
        continue;
      }
      clock.add(stamp, arrival);
      worst_s = std::max(worst_s, std::abs(to_seconds(stamp - at(t))));
    }
  }
};

TEST(ClockSteps, ASetClockGoesOnAfterASecond) {
  for (const double step_s : {3600.0, -3600.0, 5.0, -5.0, 1.7e9, -1.7e9}) {
    Watched sensor;
    sensor.add(0.0, 20.0, 0.0);
    EXPECT_FALSE(sensor.steps.take_step()) << step_s;
    sensor.add(20.0, 40.0, step_s);
    const auto found = sensor.steps.take_step();
    ASSERT_TRUE(found) << step_s;
    EXPECT_NEAR(to_seconds(*found), step_s, 0.06);
    EXPECT_FALSE(sensor.steps.take_step()) << "one event for one step";
    EXPECT_LT(sensor.worst_s, 0.06) << step_s;
    EXPECT_LT(sensor.doubtful, 25) << step_s;
    // And back again.
    sensor.add(40.0, 60.0, 0.0);
    EXPECT_NEAR(to_seconds(sensor.steps.total()), 0.0, 0.1) << step_s;
    EXPECT_LT(sensor.worst_s, 0.12) << step_s;
  }
}

TEST(ClockSteps, WhatWasStalledIsNoStep) {
  Watched sensor;
  sensor.add(0.0, 20.0, 0.0);
  // Ten seconds are delivered at once, by a program that was stopped.
  for (double t = 20.0; t < 30.0; t += 0.05) {
    const Time arrival = at(30.0 + 1e-4 * (t - 20.0));
    EXPECT_EQ(sensor.steps.corrected(at(t), arrival, sensor.clock.best_offset()), at(t));
    sensor.clock.add(at(t), arrival);
  }
  sensor.add(30.0, 50.0, 0.0);
  EXPECT_EQ(sensor.doubtful, 0);
  EXPECT_EQ(sensor.steps.total(), Duration::zero());
}

TEST(ClockSteps, ASourceThatWasAwayIsNoStep) {
  Watched sensor;
  sensor.add(0.0, 20.0, 0.0);
  sensor.add(3620.0, 3640.0, 0.0);
  EXPECT_EQ(sensor.doubtful, 0);
  EXPECT_EQ(sensor.steps.total(), Duration::zero());
}

TEST(ClockSteps, ABacklogAtTheStartIsNoStep) {
  Watched sensor;
  for (double t = 0.0; t < 10.0; t += 0.05) {
    const Time arrival = at(10.0 + 1e-4 * t);
    sensor.steps.corrected(at(t), arrival, sensor.clock.best_offset());
    sensor.clock.add(at(t), arrival);
  }
  sensor.add(10.0, 30.0, 0.0);
  EXPECT_EQ(sensor.steps.total(), Duration::zero());
}

TEST(ClockSteps, OneWrongStampIsPassedOnAsItIs) {
  Watched sensor;
  sensor.add(0.0, 20.0, 0.0);
  for (const double wrong : {3620.0, -4000.0, 9e9, -9e9}) {
    EXPECT_EQ(sensor.steps.corrected(at(wrong), at(20.0), sensor.clock.best_offset()), at(wrong));
    EXPECT_TRUE(sensor.steps.in_doubt());
  }
  sensor.add(20.0, 40.0, 0.0);
  EXPECT_EQ(sensor.doubtful, 0);
  EXPECT_EQ(sensor.steps.total(), Duration::zero());
}

/// A receiver begins with any date, until its first fix. What is refused until then must not be refused for ever.
TEST(ClockSteps, AClockThatIsWrongFromTheStartIsNotCarriedOn) {
  for (const double wrong_s : {2.4e9, -6e8, -1.7e9, 3600.0, 5.0}) {
    for (const double until : {0.05, 0.2, 60.0}) {
      Watched sensor;
      sensor.usable = {from_seconds(-3600.0), from_seconds(1.1)};
      sensor.add(0.0, until, wrong_s);
      sensor.worst_s = 0.0;
      sensor.add(until, until + 60.0, 0.0);
      EXPECT_EQ(sensor.steps.total(), Duration::zero()) << wrong_s << " s until " << until;
      EXPECT_EQ(sensor.doubtful, 0) << wrong_s << " s until " << until;
      EXPECT_LT(sensor.worst_s, 1e-6) << wrong_s << " s until " << until;
      // Once it was right, a step is one.
      sensor.add(until + 60.0, until + 80.0, 7200.0);
      EXPECT_NEAR(to_seconds(sensor.steps.total()), 7200.0, 0.1) << wrong_s << " s until " << until;
    }
  }
}

TEST(ClockSteps, StampsOfAnyValueAreTaken) {
  Watched sensor;
  sensor.add(0.0, 20.0, 0.0);
  double t = 20.0;
  for (const Time extreme : {Time::min(), Time::max(), Time{} + kLongest, Time{} - kLongest}) {
    for (int k = 0; k < 40; ++k, t += 0.05) sensor.steps.corrected(extreme, at(t), sensor.clock.best_offset());
  }
  EXPECT_LE(sensor.steps.total(), kLongest);
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
