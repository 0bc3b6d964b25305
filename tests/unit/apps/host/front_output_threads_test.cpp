// SPDX-License-Identifier: Apache-2.0
// needs plugins: odometry
#include <gtest/gtest.h>

#include "front_output.hpp"
#include "scripted_source.hpp"
#include "waymark/host/robot.hpp"

namespace waymark::host {
namespace {

constexpr const char* kYaml = R"({ initial: { x_m: 0, y_m: 0, yaw_deg: 0 },
  sensors: [{ name: wheels, plugin: odometry, model: twist }] })";

std::unique_ptr<Fusion> fusion() {
  const Robot robot = Robot::live(Config::parse(kYaml, "robot.yaml"), PluginLoader({WAYMARK_PLUGIN_DIR}));
  return robot.fusion(nullptr);
}

/// Newest belief that was published.
struct Published {
  std::mutex mutex;
  Belief belief;
  int count = 0;
  void operator()(const Belief& given) {
    const std::lock_guard lock(mutex);
    belief = given;
    ++count;
  }
  Belief last() {
    const std::lock_guard lock(mutex);
    return belief;
  }
  template <class Reached>
  bool waits_for(const Reached& reached) {
    const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (std::chrono::steady_clock::now() < give_up) {
      {
        const std::lock_guard lock(mutex);
        if (count > 0 && reached(belief)) return true;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
  }
};

TEST(FrontOutput, GoesOnWhileTheFilterIsBusy) {
  const LiveClock clock;
  const auto filter = fusion();
  for (int k = 0; k < 20; ++k) filter->add(reading(0.1 * k));
  Published published;
  FrontOutput front([&](const Belief& belief) { published(belief); }, 100.0, {true}, clock);
  front.rebase(filter->front());
  // The filter does nothing from here on.
  for (int k = 20; k < 40; ++k) front.arrived(reading(0.1 * k));
  EXPECT_TRUE(published.waits_for([](const Belief& b) { return b.mean.T_map_base.p.x() > 3.8; }));
  EXPECT_GT(front.latency().count(), 0U);
  // It follows: the front begins again at what was committed.
  for (int k = 20; k < 40; ++k) filter->add(reading(0.1 * k));
  front.rebase(filter->front());
  front.arrived(reading(4.0));
  EXPECT_TRUE(published.waits_for([](const Belief& b) { return b.stamp >= Time{} + from_seconds(4.0); }));
  EXPECT_NEAR(published.last().mean.T_map_base.p.x(), 4.0, 0.1);
}

TEST(FrontOutput, NothingOfTheFilterBeforeIsUsedAfterItWasReplaced) {
  const LiveClock clock;
  auto first = fusion();
  for (int k = 0; k < 20; ++k) first->add(reading(0.1 * k));
  const auto second = fusion();  // before the front, which uses it until its thread has ended
  for (int k = 0; k < 30; ++k) second->add(reading(0.1 * k));
  Published published;
  FrontOutput front([&](const Belief& belief) { published(belief); }, 1000.0, {true}, clock);
  front.rebase(first->front());
  EXPECT_TRUE(published.waits_for([](const Belief&) { return true; }));
  front.replace(second->front());
  first = nullptr;  // AddressSanitizer and ThreadSanitizer look at what is used of it
  for (int k = 30; k < 40; ++k) front.arrived(reading(0.1 * k));
  EXPECT_TRUE(published.waits_for([](const Belief& b) { return b.mean.T_map_base.p.x() > 3.8; }));
}

TEST(FrontOutput, AStampFarAheadDoesNotMoveIt) {
  const LiveClock clock;
  const auto filter = fusion();
  for (int k = 0; k < 20; ++k) filter->add(reading(0.1 * k));
  Published published;
  FrontOutput front([&](const Belief& belief) { published(belief); }, 200.0, {true}, clock);
  front.rebase(filter->front());
  front.arrived(reading(3600.0));
  front.arrived(reading(2.0));
  EXPECT_TRUE(published.waits_for([](const Belief& b) { return b.stamp >= Time{} + from_seconds(2.0); }));
  EXPECT_LT(published.last().stamp, Time{} + from_seconds(3.0));
}

TEST(FrontOutput, AFloodThatItCannotFollowTakesNoMemoryWithoutEnd) {
  const LiveClock clock;
  const auto filter = fusion();
  for (int k = 0; k < 20; ++k) filter->add(reading(0.1 * k));
  std::mutex busy;
  Published published;
  FrontOutput front(
      [&](const Belief& belief) {
        published(belief);
        const std::lock_guard lock(busy);
      },
      1000.0, {true}, clock);
  const Measurement newest = reading(2.0);
  {
    const std::lock_guard lock(busy);
    front.rebase(filter->front());
    EXPECT_TRUE(published.waits_for([](const Belief&) { return true; }));
    // Its thread waits for `busy`.
    for (int k = 0; k < 100'000; ++k) front.arrived(newest);
    EXPECT_LT(newest.payload.use_count(), 25'000);
  }
  EXPECT_TRUE(published.waits_for([](const Belief& b) { return b.stamp >= Time{} + from_seconds(2.0); }));
}

TEST(FrontOutput, WithoutAFilterPublishesNothing) {
  const LiveClock clock;
  Published published;
  {
    FrontOutput front([&](const Belief& belief) { published(belief); }, 500.0, {true}, clock);
    front.arrived(reading(0.0));
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_EQ(published.count, 0);  // its thread has ended
}

}  // namespace
}  // namespace waymark::host
