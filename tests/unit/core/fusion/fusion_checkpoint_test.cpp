// SPDX-License-Identifier: Apache-2.0
// needs plugins: dgps, odometry
// A log split anywhere and continued from the saved state gives the bytes of one run.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <span>
#include <sstream>
#include <stdexcept>

#include "unit/core/fusion_robot.hpp"
#include "unit/core/toy_map.hpp"
#include "waymark/base/error.hpp"

namespace waymark {
namespace {

using ::testing::HasSubstr;
using namespace test;  // NOLINT(google-build-using-namespace): the robot's parts

/// Ten seconds of a curve, with fixes that scatter and everything up to `longest` late.
std::vector<Measurement> curve(double longest) {
  std::vector<Measurement> log;
  Random random = stream(91);
  drive(log, 0.0, 10.0, 1.0, 0.2);
  for (int k = 0; k < 30; ++k) {
    const double t = 0.33 * k;
    log.push_back(fix(t, 5.0 * std::sin(0.2 * t) + 0.1 * random.normal(),
                      5.0 * (1.0 - std::cos(0.2 * t)) + 0.1 * random.normal()));
  }
  log = in_order(log);
  for (Measurement& m : log) m.arrival = m.stamp + from_seconds(uniform(random, 0.0, longest));
  std::stable_sort(log.begin(), log.end(), [](const auto& a, const auto& b) { return a.arrival < b.arrival; });
  return log;
}

/// Uses every third fix: it counts them. The hundredth measurement breaks it.
class EveryThird final : public MapModule {
 public:
  explicit EveryThird(int breaks_at) : breaks_at_(breaks_at) {}
  std::unique_ptr<ParticleMap> create_map() const override { return std::make_unique<ToyMap>(ToyMap::Fails::never); }
  std::shared_ptr<const Observation> extract(const Measurement& m, std::span<const Companion>,
                                             const MotionWindow&) override {
    if (++count_ == breaks_at_) throw std::runtime_error("a toy that breaks");
    if (count_ % 3 != 0) return nullptr;
    auto sighting = std::make_shared<test::Sighting>();
    sighting->see(Pose{}, {2.0, 1.0}, 0.01 * m.as<GnssFix>().p_map_antenna.head<2>());
    return sighting;
  }
  std::unique_ptr<ParticleMap> load_map(InArchive& in) const override { return ToyMap::load(in); }
  void save(OutArchive& out) const override { out.value(count_); }
  void load(InArchive& in) override { in.value(count_); }

 private:
  int breaks_at_;
  int count_ = 0;
};

std::vector<MapSlot> toy_map(int breaks_at) {
  MapSlot slot;
  slot.name = "toy";
  slot.module = std::make_shared<EveryThird>(breaks_at);
  slot.inputs = {1};
  return {slot};
}

struct Case {
  std::string filter;
  bool maps = false;
  double longest = 0.0;
  int map_breaks_at = 0;  // fix; 0: never
};

FusionRobot make(const Case& c) {
  return FusionRobot(kAtOrigin + "filter: " + c.filter + "\nsensors:\n" + kWheels + gps("offset_sigma_m: 0.2"), {},
                     c.maps ? toy_map(c.map_breaks_at) : std::vector<MapSlot>{});
}

std::string checkpoint(const FusionRobot& robot) {
  std::ostringstream stream;
  OutArchive out(stream);
  const_cast<FusionRobot&>(robot).fusion().save(out);
  return stream.str();
}

void resume(FusionRobot& robot, const std::string& bytes, const std::vector<Measurement>& log) {
  std::istringstream stream(bytes);
  InArchive in(stream);
  std::size_t next = 0;
  robot.fusion().resume(in, [&]() -> std::optional<Measurement> {
    return next < log.size() ? std::optional(log[next++]) : std::nullopt;
  });
}

class FusionCheckpoint : public ::testing::TestWithParam<Case> {};

TEST_P(FusionCheckpoint, ContinuesWithTheSameBytes) {
  const std::vector<Measurement> log = curve(GetParam().longest);
  FusionRobot whole = make(GetParam());
  whole.play(log);
  for (const std::size_t split :
       {std::size_t{0}, std::size_t{1}, std::size_t{17}, std::size_t{64}, std::size_t{100}, log.size()}) {
    FusionRobot first = make(GetParam());
    for (std::size_t i = 0; i < split; ++i) first.fusion().add(log[i]);
    FusionRobot second = make(GetParam());
    resume(second, checkpoint(first), log);
    EXPECT_TRUE(checkpoint(second) == checkpoint(first)) << split;
    EXPECT_TRUE(second.seen().empty()) << "earlier snapshots are not repeated";
    for (std::size_t i = split; i < log.size(); ++i) second.fusion().add(log[i]);
    second.fusion().finish();
    EXPECT_TRUE(second.bytes() == whole.bytes()) << split;
    ASSERT_LE(second.seen().size(), whole.seen().size());
    const auto tail = whole.seen().end() - static_cast<std::ptrdiff_t>(second.seen().size());
    for (std::size_t i = 0; i < second.seen().size(); ++i) {
      ASSERT_EQ(second.seen()[i].stamp, tail[static_cast<std::ptrdiff_t>(i)].stamp);
      ASSERT_TRUE(second.seen()[i].belief.P == tail[static_cast<std::ptrdiff_t>(i)].belief.P) << split << " " << i;
    }
    const RunReport a = whole.fusion().report();
    const RunReport b = second.fusion().report();
    for (std::size_t i = 0; i < a.sensors.size(); ++i) {
      EXPECT_EQ(a.sensors[i].fused, b.sensors[i].fused);
      EXPECT_EQ(a.sensors[i].mapped, b.sensors[i].mapped);
      EXPECT_EQ(a.sensors[i].skipped, b.sensors[i].skipped);
      EXPECT_EQ(a.sensors[i].ignored, b.sensors[i].ignored);
      EXPECT_EQ(a.sensors[i].measurements, b.sensors[i].measurements);
      EXPECT_EQ(a.sensors[i].processed_late, b.sensors[i].processed_late);
    }
    ASSERT_EQ(a.smoothed.size(), b.smoothed.size());
    for (std::size_t i = 0; i < a.smoothed.size(); ++i) ASSERT_TRUE(a.smoothed[i].P == b.smoothed[i].P);
  }
}

/// Of a running robot nothing can be read again: what is buffered, and what waits in front of the filter, is kept.
TEST_P(FusionCheckpoint, ARunningRobotContinuesWithWhatWaits) {
  const std::vector<Measurement> log = curve(GetParam().longest);
  FusionRobot whole = make(GetParam());
  whole.play(log);
  for (const std::size_t split : {std::size_t{17}, std::size_t{64}, std::size_t{100}}) {
    const std::size_t waiting_until = split + 7;
    FusionRobot first = make(GetParam());
    for (std::size_t i = 0; i < split; ++i) first.fusion().add(log[i]);
    std::stringstream stream;
    OutArchive out(stream);
    first.fusion().save_with_measurements(out, std::span(log).subspan(split, waiting_until - split));

    FusionRobot second = make(GetParam());
    InArchive in(stream);
    const std::vector<Measurement> waiting = second.fusion().resume_with_measurements(in);
    ASSERT_EQ(waiting.size(), waiting_until - split);
    for (const Measurement& m : waiting) second.fusion().add(m);
    for (std::size_t i = waiting_until; i < log.size(); ++i) second.fusion().add(log[i]);
    second.fusion().finish();
    EXPECT_TRUE(second.bytes() == whole.bytes()) << split;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Hosts, FusionCheckpoint,
    ::testing::Values(Case{"{}", false, 0.0}, Case{"{ history_s: 0 }", false, 0.0},
                      Case{"{ history_s: 1, smooth: true }", false, 0.4},
                      Case{"{ history_s: 0, smooth: true }", false, 0.0}, Case{"{ max_latency_s: 0.5 }", false, 0.4},
                      Case{"{ particles: 10 }", true, 0.0}, Case{"{ particles: 10, max_latency_s: 0.3 }", true, 0.3},
                      Case{"{ particles: 10 }", true, 0.4}, Case{"{ particles: 10 }", true, 0.0, 10}));

TEST(FusionCheckpointModes, AMapThatIsSwitchedOffStaysSo) {
  const std::vector<Measurement> log = curve(0.0);
  FusionRobot first = make({"{ particles: 10 }", true});
  for (std::size_t i = 0; i < 60; ++i) first.fusion().add(log[i]);
  const std::uint64_t mapped = first.fusion().report().sensors[1].mapped;
  EXPECT_GT(mapped, 0U);
  first.fusion().set_map_enabled(0, false);
  for (std::size_t i = 60; i < 100; ++i) first.fusion().add(log[i]);
  EXPECT_EQ(first.fusion().report().sensors[1].mapped, mapped);

  FusionRobot second = make({"{ particles: 10 }", true});
  resume(second, checkpoint(first), log);
  EXPECT_FALSE(second.fusion().map_enabled(0));
  second.fusion().set_map_enabled(0, true);
  for (std::size_t i = 100; i < log.size(); ++i) second.fusion().add(log[i]);
  EXPECT_GT(second.fusion().report().sensors[1].mapped, mapped);
}

TEST(FusionCheckpointModes, AMapOutOfServiceCannotBeSwitched) {
  const std::vector<Measurement> log = curve(0.0);
  FusionRobot robot = make({"{ particles: 10 }", true, 0.0, 3});
  robot.play(log);
  EXPECT_THROW(robot.fusion().set_map_enabled(0, true), Error);
}

TEST(FusionHealth, DroppedMeasurementsAreShownForTwoSeconds) {
  FusionRobot robot = make({"{}"});
  const std::vector<Measurement> log = curve(0.0);
  for (std::size_t i = 0; i < 60; ++i) robot.fusion().add(log[i]);
  EXPECT_EQ(robot.fusion().health().sensors[1].state, SensorHealth::State::ok);
  robot.fusion().note_dropped(1);
  robot.fusion().add(log[60]);
  EXPECT_EQ(robot.fusion().health().sensors[1].state, SensorHealth::State::degraded);
  EXPECT_THAT(robot.fusion().health().reason, HasSubstr("gps is degraded: measurements are dropped"));
  for (std::size_t i = 61; i < log.size(); ++i) robot.fusion().add(log[i]);
  EXPECT_EQ(robot.fusion().health().sensors[1].state, SensorHealth::State::ok);
}

TEST(FusionCheckpointErrors, AnotherConfigurationOrLogIsRefused) {
  const std::vector<Measurement> log = curve(0.0);
  FusionRobot first = make({"{}"});
  for (std::size_t i = 0; i < 60; ++i) first.fusion().add(log[i]);
  const std::string bytes = checkpoint(first);

  FusionRobot other(kAtOrigin + "sensors:\n  - { name: tracks, plugin: odometry, model: twist }\n" + gps());
  EXPECT_THROW(resume(other, bytes, log), DataError);
  FusionRobot crowd = make({"{ particles: 5 }"});
  EXPECT_THROW(resume(crowd, bytes, log), DataError);
  FusionRobot fewer_states(kAtOrigin + "sensors:\n" + kWheels + gps());
  EXPECT_THROW(resume(fewer_states, bytes, log), DataError);
  FusionRobot with_map = make({"{}", true});
  EXPECT_THROW(resume(with_map, bytes, log), DataError);
  FusionRobot short_log = make({"{}"});
  EXPECT_THROW(resume(short_log, bytes, {log.begin(), log.begin() + 30}), DataError);
  FusionRobot broken = make({"{}"});
  EXPECT_THROW(resume(broken, bytes.substr(0, bytes.size() / 2), log), DataError);
}

}  // namespace
}  // namespace waymark
