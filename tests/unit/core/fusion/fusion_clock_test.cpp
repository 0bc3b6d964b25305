// SPDX-License-Identifier: Apache-2.0
// needs plugins: dgps, odometry
// Implausible stamps, and the health of the sensors.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "unit/core/fusion_robot.hpp"
#include "unit/core/toy_map.hpp"

namespace waymark {
namespace {

using ::testing::HasSubstr;
using namespace test;  // NOLINT(google-build-using-namespace): the robot's parts

constexpr double kEpoch = 1.7e9;  // a log of today, in UTC

/// Twenty seconds straight on, with a fix every second.
std::vector<Measurement> straight() {
  std::vector<Measurement> log;
  for (int k = 0; k < 200; ++k) log.push_back(twist(kEpoch + 0.1 * k, 1.0));
  for (int k = 0; k < 20; ++k) log.push_back(fix(kEpoch + k, k, 0.0));
  return in_order(log);
}

FusionRobot robot_on(const std::vector<Measurement>& log) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels + gps());
  robot.play(log);
  return robot;
}

/// The log with the stamp of fix number `which` set to `stamp`, arrivals as they were.
std::vector<Measurement> with_stamp(int which, Time stamp) {
  std::vector<Measurement> log = straight();
  for (Measurement& m : log) {
    if (m.sensor == 1 && which-- == 0) m.stamp = stamp;
  }
  return log;
}

TEST(FusionClock, NamesAZeroStamp) {
  FusionRobot robot = robot_on(with_stamp(10, Time{}));
  EXPECT_EQ(robot.report(1).mistimed, 1U);
  EXPECT_EQ(robot.report(1).fused, 19U);
  EXPECT_THAT(robot.events(), HasSubstr("gps: zero stamp"));
}

TEST(FusionClock, AcceptsALogThatBeginsAtZero) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels + gps());
  robot.play({twist(0.0, 1.0), twist(0.1, 1.0)});
  EXPECT_EQ(robot.report(0).mistimed, 0U);
  EXPECT_EQ(robot.report(0).fused, 2U);
}

TEST(FusionClock, NamesAStampFromTheFuture) {
  FusionRobot robot = robot_on(with_stamp(10, at(kEpoch + 12.0)));
  EXPECT_EQ(robot.report(1).mistimed, 1U);
  EXPECT_THAT(robot.events(), HasSubstr("2.000 s after its own arrival"));
}

TEST(FusionClock, AnEarlyClockMayBeSetForwardByItsDelay) {
  std::vector<Measurement> log = straight();
  for (Measurement& m : log) {
    if (m.sensor == 1) m.stamp = m.arrival = m.stamp - from_seconds(0.8);
  }
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels +
                    "  - { name: gps, plugin: dgps, base_p_antenna_m: none, sigma_m: 0.5, delay_s: -0.8 }\n");
  robot.play(in_order(log));
  EXPECT_EQ(robot.report(1).mistimed, 0U);
  EXPECT_GT(robot.report(1).fused, 15U);
  EXPECT_NEAR(robot.pose().p.x(), 19.9, 0.3);
}

TEST(FusionClock, NamesAStampFarInThePast) {
  FusionRobot robot = robot_on(with_stamp(10, at(kEpoch - 1e6)));
  EXPECT_EQ(robot.report(1).mistimed, 1U);
  EXPECT_THAT(robot.events(), HasSubstr("before the time of arrival: another clock, or an old message"));
}

TEST(FusionClock, NamesAClockThatWentBackwards) {
  std::vector<Measurement> log = straight();
  log.push_back(fix(kEpoch - 1e6, 0.0, 0.0));  // with its arrival
  FusionRobot robot = robot_on(log);
  EXPECT_EQ(robot.report(1).mistimed, 1U);
  EXPECT_THAT(robot.events(), HasSubstr("before all others: the clock went backwards"));
}

TEST(FusionClock, OneArrivalYearsAheadDoesNotMakeTheOthersLate) {
  std::vector<Measurement> log = straight();
  Measurement stray = fix(kEpoch + 3e8, 0.0, 0.0);
  stray.sequence = 5000;
  log.insert(log.begin() + 100, stray);
  FusionRobot robot = robot_on(log);
  EXPECT_EQ(robot.report(1).mistimed, 1U);
  EXPECT_EQ(robot.report(1).fused, 20U);
  EXPECT_EQ(robot.report(0).fused, 200U);
  EXPECT_THAT(robot.events(), HasSubstr("the clock jumped"));
}

TEST(FusionClock, AClockThatWasSetIsFollowedOnceSeveralAgree) {
  std::vector<Measurement> log = straight();
  for (std::size_t i = 100; i < log.size(); ++i) {
    log[i].stamp += std::chrono::hours(2);
    log[i].arrival = log[i].stamp;
  }
  FusionRobot robot = robot_on(log);
  EXPECT_EQ(robot.report(0).mistimed + robot.report(1).mistimed, 4U);
}

TEST(FusionClock, NamesAStuckClock) {
  std::vector<Measurement> log = straight();
  for (int k = 0; k < 30; ++k) {
    Measurement m = twist(kEpoch + 20.0, 1.0);
    m.arrival = at(kEpoch + 20.0 + 0.1 * k);
    m.sequence = 6000 + static_cast<std::uint64_t>(k);
    log.push_back(m);
  }
  FusionRobot robot = robot_on(log);
  EXPECT_EQ(robot.report(0).mistimed, 20U);
  EXPECT_THAT(robot.events(), HasSubstr("the clock is stuck"));
}

TEST(FusionClock, MeasuresLatencyAndGaps) {
  std::vector<Measurement> log = straight();
  for (Measurement& m : log) {
    if (m.sensor == 1) m.arrival += from_seconds(0.2);
  }
  std::erase_if(log, [](const Measurement& m) {
    return m.sensor == 1 && m.stamp > at(kEpoch + 4.5) && m.stamp < at(kEpoch + 8.5);
  });
  std::stable_sort(log.begin(), log.end(), [](const auto& a, const auto& b) { return a.arrival < b.arrival; });
  const SensorReport report = robot_on(log).report(1);
  EXPECT_NEAR(report.latency_mean_s, 0.2, 1e-6);
  EXPECT_NEAR(report.latency_max_s, 0.2, 1e-6);
  EXPECT_NEAR(report.gap_max_s, 5.0, 1e-6);
}

// ---- health

/// Plays the log and returns the health after every measurement.
struct Judged {
  double t;
  Health health;
};
std::vector<Judged> judged(const std::vector<Measurement>& log, const std::string& more = "") {
  FusionRobot robot(kAtOrigin + more + "sensors:\n" + kWheels + gps("jump_sigmas: 0"));  // the host's gate alone
  std::vector<Judged> result;
  for (const Measurement& m : log) {
    robot.fusion().add(m);
    if (robot.fusion().started()) {
      result.push_back({to_seconds(m.arrival.time_since_epoch()) - kEpoch, robot.fusion().health()});
    }
  }
  return result;
}

TEST(FusionHealth, IsOkOnALogWithoutFaults) {
  for (const Judged& j : judged(straight())) {
    EXPECT_EQ(j.health.state, Health::State::ok) << j.t << " " << j.health.reason;
    EXPECT_NEAR(j.health.probability_off_3_sigma, 0.0111, 1e-3);
  }
}

TEST(FusionHealth, ASilentSensorIsNamed) {
  std::vector<Measurement> log = straight();
  std::erase_if(log, [](const Measurement& m) { return m.sensor == 1 && m.stamp > at(kEpoch + 5.5); });
  const std::vector<Judged> all = judged(log);
  const Health& last = all.back().health;
  EXPECT_EQ(last.sensors[1].state, SensorHealth::State::silent);
  EXPECT_EQ(last.state, Health::State::degraded);
  // After ten seconds what matters is not the sensor but what is missing.
  EXPECT_THAT(last.reason, HasSubstr("dead reckoning"));
  const auto early = std::find_if(all.begin(), all.end(), [](const Judged& j) { return j.t > 12.0; });
  EXPECT_THAT(early->health.reason, HasSubstr("gps is silent"));
}

TEST(FusionHealth, ASensorThatTheGateRejectsIsFaulty) {
  std::vector<Measurement> log = straight();
  for (Measurement& m : log) {
    if (m.sensor == 1 && m.stamp > at(kEpoch + 5.5)) m.payload = fix(0.0, 300.0, 300.0).payload;
  }
  const Health last = judged(log).back().health;
  EXPECT_EQ(last.sensors[1].state, SensorHealth::State::faulty) << last.reason;
  EXPECT_GT(last.probability_off_3_sigma, 0.05);
}

/// Has the landmarks of one place, and detects one between two times.
class OneLandmark final : public MapModule {
 public:
  OneLandmark(bool loaded, double from, double to) : loaded_(loaded), from_(from), to_(to) {}
  std::unique_ptr<ParticleMap> create_map() const override { return std::make_unique<ToyMap>(ToyMap::Fails::never); }
  bool has_prior_map() const override { return loaded_; }
  std::shared_ptr<const Observation> extract(const Measurement& trigger, std::span<const Companion>,
                                             const MotionWindow&) override {
    auto sighting = std::make_shared<test::Sighting>();
    const double t = to_seconds(trigger.stamp.time_since_epoch()) - kEpoch;
    if (t >= from_ && t < to_) sighting->see(Pose::planar(t, 0.0, 0.0), {20.0, 5.0}, Eigen::Vector2d::Zero());
    return sighting;
  }
  std::unique_ptr<ParticleMap> load_map(InArchive& in) const override { return ToyMap::load(in); }

 private:
  bool loaded_;
  double from_;
  double to_;
};

/// The health every second of a straight drive of 30 s with such a map, and what the run noted.
std::pair<std::vector<Health>, std::string> with_map(bool loaded, double from, double to) {
  MapSlot slot;
  slot.name = "place";
  slot.module = std::make_shared<OneLandmark>(loaded, from, to);
  slot.inputs = {1};
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels + "  - { name: scanner, payload: LaserScan }\n", {}, {slot});
  std::vector<Measurement> log;
  drive(log, kEpoch, kEpoch + 30.0, 1.0);
  for (int k = 0; k < 30; ++k) log.push_back(reading(kEpoch + k, 1, std::make_shared<LaserScan>()));
  std::vector<Health> all;
  for (const Measurement& m : in_order(log)) {
    robot.fusion().add(m);
    if (m.sensor == 1) all.push_back(robot.fusion().health());
  }
  return {all, robot.events()};
}

TEST(FusionHealth, ARobotThatIsNotLocalizedInItsLoadedMapIsNotOk) {
  const auto [all, events] = with_map(true, 100.0, 100.0);
  EXPECT_EQ(all[2].state, Health::State::ok) << "a scan or two may miss";
  EXPECT_EQ(all[8].state, Health::State::degraded);
  EXPECT_THAT(all[8].reason, HasSubstr("loaded map"));
  EXPECT_THAT(all[20].reason, HasSubstr("dead reckoning"));
  EXPECT_THAT(events, HasSubstr("scanner: most of its scans do not localise the robot in the loaded map"));
}

TEST(FusionHealth, WithoutInformationOfTheMapItIsDeadReckoning) {
  for (const bool loaded : {true, false}) {
    const auto [all, events] = with_map(loaded, 0.0, 12.0);
    EXPECT_EQ(all[20].state, Health::State::ok) << all[20].reason;
    EXPECT_THAT(all[25].reason, HasSubstr("dead reckoning"));
  }
}

TEST(FusionHealth, AMapWithoutInformationYetIsNoConcern) {
  const auto [all, events] = with_map(false, 100.0, 100.0);
  EXPECT_EQ(all.back().state, Health::State::ok) << all.back().reason;
  EXPECT_EQ(events, "");
}

TEST(FusionHealth, WithoutAMotionSensorThePoseIsLost) {
  std::vector<Measurement> log = straight();
  std::erase_if(log, [](const Measurement& m) { return m.sensor == 0 && m.stamp > at(kEpoch + 10.0); });
  const Health last = judged(log).back().health;
  EXPECT_EQ(last.state, Health::State::lost);
  EXPECT_THAT(last.reason, HasSubstr("no motion source delivers"));
}

TEST(FusionHealth, AnUncertainPositionIsLost) {
  std::vector<Measurement> log = straight();
  std::erase_if(log, [](const Measurement& m) { return m.sensor == 1; });
  EXPECT_EQ(judged(log, "health: { lost_sigma_m: 0.05 }\n").back().health.state, Health::State::lost);
}

}  // namespace
}  // namespace waymark
