// SPDX-License-Identifier: Apache-2.0
#include "fusion/measurement_queue.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <tuple>
#include <vector>

#include "unit/core/beliefs.hpp"

namespace waymark {
namespace {

using Key = std::tuple<double, unsigned, unsigned>;  // stamp [s], sensor, sequence

Measurement make(double stamp, double arrival, std::uint32_t sensor = 0, std::uint64_t sequence = 0) {
  Measurement m;
  m.stamp = test::at(stamp);
  m.arrival = test::at(arrival);
  m.sensor = sensor;
  m.sequence = sequence;
  return m;
}

Key key(const Measurement& m) {
  return {to_seconds(m.stamp.time_since_epoch()), m.sensor, static_cast<unsigned>(m.sequence)};
}

/// What comes out when measurements arrive in this order.
std::vector<Key> play(fusion::MeasurementQueue& queue, const std::vector<Measurement>& arrivals) {
  std::vector<Key> out;
  for (const Measurement& m : arrivals) {
    queue.push(m);
    while (const auto due = queue.pop_due()) out.push_back(key(*due));
  }
  while (const auto rest = queue.pop()) out.push_back(key(*rest));
  return out;
}

TEST(MeasurementQueue, IsEmptyAtFirst) {
  fusion::MeasurementQueue queue(from_seconds(0.1));
  EXPECT_FALSE(queue.pop_due().has_value());
  EXPECT_FALSE(queue.pop().has_value());
  EXPECT_EQ(queue.size(), 0U);
}

TEST(MeasurementQueue, HoldsBackUntilTheStampIsOlderThanTheLatency) {
  fusion::MeasurementQueue queue(from_seconds(0.2));
  queue.push(make(1.0, 1.0));
  EXPECT_FALSE(queue.pop_due().has_value());
  queue.push(make(1.2, 1.2));
  EXPECT_FALSE(queue.pop_due().has_value()) << "exactly as old as the latency is not yet due";
  queue.push(make(1.3, 1.200000001));
  EXPECT_TRUE(queue.pop_due().has_value());
  EXPECT_FALSE(queue.pop_due().has_value());
  EXPECT_EQ(queue.size(), 2U);
}

TEST(MeasurementQueue, EqualStampsComeInTheOrderOfSensorThenSequence) {
  fusion::MeasurementQueue queue(Duration{0});
  const auto out =
      play(queue, {make(1.0, 1.0, 2, 1), make(1.0, 1.0, 0, 9), make(1.0, 1.0, 2, 0), make(1.0, 1.0, 1, 5)});
  EXPECT_EQ(out, (std::vector<Key>{{1.0, 0, 9}, {1.0, 1, 5}, {1.0, 2, 0}, {1.0, 2, 1}}));
}

TEST(MeasurementQueue, OvertakingWithinTheWindowGivesTheOrderOfIdealArrival) {
  Random random = test::stream(8);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<Measurement> ideal;
    for (unsigned k = 0; k < 200; ++k) {
      const double stamp = 0.05 * (k / 2);  // pairs with equal stamps
      ideal.push_back(make(stamp, stamp, k % 3, k));
    }
    std::vector<Measurement> delayed = ideal;
    for (Measurement& m : delayed) m.arrival = m.stamp + from_seconds(test::uniform(random, 0.0, 0.3));
    std::stable_sort(delayed.begin(), delayed.end(),
                     [](const auto& a, const auto& b) { return a.arrival < b.arrival; });
    fusion::MeasurementQueue in_order(from_seconds(0.3));
    fusion::MeasurementQueue overtaken(from_seconds(0.3));
    EXPECT_EQ(play(overtaken, delayed), play(in_order, ideal));
  }
}

TEST(MeasurementQueue, RefusesWhatIsOlderThanWhatWasHandedOut) {
  fusion::MeasurementQueue queue(from_seconds(0.1));
  queue.push(make(1.0, 1.0));
  queue.push(make(2.0, 2.0));
  ASSERT_TRUE(queue.pop_due().has_value());
  EXPECT_FALSE(queue.push(make(0.999, 2.0)));
  EXPECT_TRUE(queue.push(make(1.0, 2.0, 1))) << "as old as what was handed out is not older";
  EXPECT_EQ(queue.size(), 2U);
}

TEST(MeasurementQueue, ALateArrivalStillMovesTheClock) {
  fusion::MeasurementQueue queue(from_seconds(0.1));
  queue.push(make(1.0, 1.0));
  queue.push(make(2.0, 2.0));
  while (queue.pop_due()) {
  }
  EXPECT_FALSE(queue.push(make(0.5, 2.2)));
  EXPECT_TRUE(queue.pop_due().has_value());
}

TEST(MeasurementQueue, ListsWaitingMeasurementsInOrder) {
  fusion::MeasurementQueue queue(from_seconds(1.0));
  for (const double stamp : {3.0, 1.0, 2.0}) queue.push(make(stamp, 3.0));
  std::vector<Key> waiting;
  for (const Measurement& m : queue.waiting()) waiting.push_back(key(m));
  EXPECT_EQ(waiting, (std::vector<Key>{{1.0, 0, 0}, {2.0, 0, 0}, {3.0, 0, 0}}));
}

}  // namespace
}  // namespace waymark
