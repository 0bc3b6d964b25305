// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <algorithm>
#include <chrono>
#include <future>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "live_input.hpp"
#include "paced_log.hpp"
#include "scripted_source.hpp"
#include "waymark/interface/command.hpp"

namespace waymark::host {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

std::vector<Measurement> readings(int count) {
  std::vector<Measurement> all;
  all.reserve(static_cast<std::size_t>(count));
  for (int k = 0; k < count; ++k) all.push_back(reading(0.01 * k));
  return all;
}

/// Waits until `input` has read that many measurements of its first channel.
void wait_for(const LiveInput& input, std::uint64_t received) {
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (input.counts().front().received < received && std::chrono::steady_clock::now() < give_up)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  ASSERT_GE(input.counts().front().received, received);
}

struct Fed {
  std::shared_ptr<LiveClock> clock = std::make_shared<LiveClock>();
  std::unique_ptr<LiveInput> input;
  explicit Fed(std::vector<std::shared_ptr<Source>> sources)
      : input(std::make_unique<LiveInput>(std::move(sources), clock)) {}
};

TEST(LiveInput, NothingOfManySourcesIsLostAndArrivalsAreInOrder) {
  constexpr int kEach = 5000;
  std::vector<std::shared_ptr<Source>> sources;
  for (const char* name : {"a", "b", "c"})
    sources.push_back(std::make_shared<Scripted>(std::vector<std::string>{name}, readings(kEach)));
  Fed setup(std::move(sources));
  LiveInput& input = *setup.input;
  input.configure({.capacity = 100}, {});
  std::vector<int> count(3, 0);
  std::vector<Time> last(3, Time::min());
  Time arrival = Time::min();
  std::uint64_t sequence = 0;
  while (const auto m = input.next()) {
    EXPECT_GE(m->arrival, arrival);
    EXPECT_GT(m->stamp, last[m->sensor]) << "the order of one source";
    EXPECT_EQ(m->sequence, sequence++);
    arrival = m->arrival;
    last[m->sensor] = m->stamp;
    ++count[m->sensor];
  }
  EXPECT_THAT(count, ElementsAre(kEach, kEach, kEach));
}

TEST(LiveInput, AStampThatIsNotKnownIsTheArrival) {
  Measurement unknown = reading(0.0);
  unknown.stamp = kUnknownStamp;
  Fed setup({std::make_shared<Scripted>(std::vector<std::string>{"a"}, std::vector{unknown})});
  const auto m = setup.input->next();
  ASSERT_TRUE(m);
  EXPECT_EQ(m->stamp, m->arrival);
  EXPECT_GT(m->arrival, Time{} + std::chrono::years(50));
}

/// A sensor of 200 Hz that is read as it measures, and of which 0.3 s are lost.
class LosesSome final : public Source {
 public:
  const std::vector<Channel>& channels() const override { return channels_; }
  std::optional<Measurement> next() override {
    if (next_ == 100) next_ += 60;
    if (next_ == 460) return std::nullopt;
    const auto due = std::chrono::milliseconds(5) * next_++;
    std::this_thread::sleep_until(begin_ + due);
    Measurement measurement = reading(0.0);
    measurement.stamp = first_ + due;
    return measurement;
  }
  bool is_live() const override { return true; }

 private:
  std::vector<Channel> channels_{{"a", std::string(BodyTwist::kType)}};
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  Time first_ = Time{} + from_seconds(1.7e9);
  int next_ = 0;
};

TEST(LiveInput, MeasurementsThatDoNotArriveAreMissedByTheirStamps) {
  Fed setup({std::make_shared<LosesSome>()});
  LiveInput& input = *setup.input;
  std::vector<LiveInput::ChannelGap> gaps;
  while (input.next()) std::ranges::move(input.take_gaps(), std::back_inserter(gaps));
  ASSERT_THAT(gaps, SizeIs(1));
  EXPECT_EQ(gaps[0].channel, 0U);
  EXPECT_EQ(gaps[0].gap.missing, 60U);
  EXPECT_NEAR(gaps[0].gap.longest_s, 0.305, 1e-6);
  EXPECT_EQ(input.counts().front().gaps.missing(), 60U);
}

TEST(LiveInput, ScansAreThinnedIfTheFilterFallsBehind) {
  std::vector<Measurement> script = readings(200);
  Fed setup({std::make_shared<Scripted>(std::vector<std::string>{"lidar"}, script, true)});
  LiveInput& input = *setup.input;
  input.configure({}, {{.thin_after = Duration(1)}});
  const auto first = input.next();
  ASSERT_TRUE(first);
  wait_for(input, 200);
  int delivered = 1;
  Time newest = first->stamp;
  while (input.waiting() > 0) {
    newest = input.next()->stamp;
    ++delivered;
  }
  EXPECT_LT(delivered, 10);
  EXPECT_EQ(newest, script.back().stamp);
  EXPECT_EQ(input.counts().front().dropped + static_cast<std::uint64_t>(delivered), 200U);
  EXPECT_THAT(input.take_dropped(), SizeIs(200 - delivered));
  EXPECT_THAT(input.take_events(), Not(IsEmpty()));
}

TEST(LiveInput, ASensorWithoutThatPolicyIsNotThinned) {
  Fed setup({std::make_shared<Scripted>(std::vector<std::string>{"lidar"}, readings(200), true)});
  setup.input->configure({}, {{.thin_after = std::chrono::hours(1)}});
  ASSERT_TRUE(setup.input->next());
  wait_for(*setup.input, 200);
  EXPECT_EQ(setup.input->waiting(), 199U);
  EXPECT_EQ(setup.input->counts().front().dropped, 0U);
}

TEST(LiveInput, WhatWaitsCanBeKeptForACheckpoint) {
  Fed setup({std::make_shared<Scripted>(std::vector<std::string>{"a"}, readings(20), true)});
  ASSERT_TRUE(setup.input->next());
  wait_for(*setup.input, 20);
  setup.input->command("disable gps");
  const std::vector<Measurement> kept = setup.input->waiting_measurements();
  ASSERT_THAT(kept, SizeIs(19)) << "without the command";
  for (const Measurement& copy : kept) EXPECT_EQ(setup.input->next()->sequence, copy.sequence);
}

TEST(LiveInput, NumbersGoOnWhereARunEnded) {
  Fed setup({std::make_shared<Scripted>(std::vector<std::string>{"a"}, readings(1))});
  setup.input->number_from(77);
  EXPECT_EQ(setup.input->next()->sequence, 77U);
  EXPECT_EQ(setup.input->next_sequence(), 78U);
}

TEST(LiveInput, AFullQueueLosesTheOldestOfTheSensorsThatAllowIt) {
  Fed setup({std::make_shared<Scripted>(std::vector<std::string>{"camera"}, readings(1000), true)});
  LiveInput& input = *setup.input;
  input.configure({.capacity = 100}, {{.may_drop = true}});
  ASSERT_TRUE(input.next());
  wait_for(input, 1000);
  EXPECT_LE(input.waiting(), 100U);
  EXPECT_GE(input.counts().front().dropped, 899U);
  EXPECT_EQ(input.counts().front().waits, 0U);
  EXPECT_THAT(input.take_events(), ElementsAre(HasSubstr("the oldest of camera are dropped")));
}

TEST(LiveInput, AFullQueueMakesOtherSourcesWait) {
  Fed setup({std::make_shared<Scripted>(std::vector<std::string>{"wheels"}, readings(1000))});
  LiveInput& input = *setup.input;
  input.configure({.capacity = 10}, {});
  int count = 0;
  while (input.next()) ++count;
  EXPECT_EQ(count, 1000);
  EXPECT_EQ(input.counts().front().dropped, 0U);
  EXPECT_GT(input.counts().front().waits, 0U);
  EXPECT_THAT(input.take_events(), ElementsAre(HasSubstr("the source of wheels waits, too")));
}

TEST(LiveInput, ACommandTakesItsPlaceInTheQueue) {
  Fed setup({std::make_shared<Scripted>(std::vector<std::string>{"a"}, readings(1), true)});
  ASSERT_TRUE(setup.input->next());
  const std::uint64_t number = setup.input->command("disable gps");
  const auto m = setup.input->next();
  ASSERT_TRUE(m);
  EXPECT_EQ(m->sensor, 1U);
  EXPECT_EQ(m->sequence, number);
  EXPECT_EQ(m->as<Command>().text, "disable gps");
}

TEST(LiveInput, StopEndsAWaitingReader) {
  Fed setup({std::make_shared<Scripted>(std::vector<std::string>{"a"}, readings(1), true)});
  std::atomic<bool> stop{false};
  setup.input->configure({.stop = &stop}, {});
  ASSERT_TRUE(setup.input->next());
  auto end = std::async(std::launch::async, [&] { return setup.input->next(); });
  EXPECT_EQ(end.wait_for(std::chrono::milliseconds(20)), std::future_status::timeout);
  stop = true;
  EXPECT_FALSE(end.get());
  setup.input->stop();
}

TEST(LiveInput, ASourceThatFailsIsReportedAndTheOthersGoOn) {
  class Failing final : public Source {
   public:
    const std::vector<Channel>& channels() const override { return channels_; }
    std::optional<Measurement> next() override { throw std::runtime_error("unplugged"); }

   private:
    std::vector<Channel> channels_{{"b", std::string(BodyTwist::kType)}};
  };
  Fed setup({std::make_shared<Scripted>(std::vector<std::string>{"a"}, readings(50)), std::make_shared<Failing>()});
  int count = 0;
  while (setup.input->next()) ++count;
  EXPECT_EQ(count, 50);
  EXPECT_THAT(setup.input->take_events(), ElementsAre(HasSubstr("unplugged")));
}

/// A list, with the time of a simulation.
class Simulation final : public Source {
 public:
  Simulation() : script_(std::vector<std::string>{"a"}, std::vector{reading(11.9), reading(12.0)}) {}
  const std::vector<Channel>& channels() const override { return script_.channels(); }
  std::optional<Measurement> next() override {
    now_ += std::chrono::seconds(1);
    return script_.next();
  }
  std::optional<Time> simulated_time() const override { return now_; }

 private:
  Scripted script_;
  Time now_{std::chrono::seconds(11)};
};

TEST(LiveInput, ArrivalsAreInTheTimeOfASimulation) {
  const auto simulation = std::make_shared<Simulation>();
  const auto clock = std::make_shared<LiveClock>(simulation);
  LiveInput input({simulation}, clock);
  EXPECT_EQ(input.next()->arrival, Time{std::chrono::seconds(12)});
  EXPECT_EQ(input.next()->arrival, Time{std::chrono::seconds(13)});
}

TEST(PacedLog, DeliversWhenTheRobotWould) {
  const auto clock = std::make_shared<LiveClock>();
  PacedLog log(std::make_shared<Scripted>(std::vector<std::string>{"a"}, std::vector{reading(10.0), reading(10.05)}),
               clock);
  const auto first = log.next();
  const auto second = log.next();
  ASSERT_TRUE(first && second);
  EXPECT_EQ(second->stamp - first->stamp, from_seconds(0.05));
  EXPECT_GE(clock->now(), second->arrival);
  EXPECT_LT(clock->now() - first->arrival, from_seconds(5.0));
  EXPECT_FALSE(log.next());
}

TEST(PacedLog, MovesNoTimeBeyondAllTimes) {
  Measurement stray = reading(10.0);
  stray.stamp = Time::min();
  Measurement strange = reading(10.0);
  strange.arrival = strange.stamp = Time::max();
  PacedLog log(std::make_shared<Scripted>(std::vector<std::string>{"a"}, std::vector{stray, strange, reading(10.0)}),
               std::make_shared<LiveClock>());
  EXPECT_EQ(log.next()->stamp, Time::max());
  EXPECT_EQ(log.next()->arrival, Time::max());
  EXPECT_TRUE(log.next());
}

TEST(PacedLog, StopEndsItsWaiting) {
  PacedLog log(std::make_shared<Scripted>(std::vector<std::string>{"a"}, std::vector{reading(0.0), reading(1e6)}),
               std::make_shared<LiveClock>());
  ASSERT_TRUE(log.next());
  auto end = std::async(std::launch::async, [&] { return log.next(); });
  log.stop();
  EXPECT_FALSE(end.get());
}

}  // namespace
}  // namespace waymark::host
