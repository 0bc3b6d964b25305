// SPDX-License-Identifier: Apache-2.0
// needs plugins: dgps, odometry
#include "waymark/host/fusion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "unit/core/fusion_robot.hpp"
#include "waymark/base/error.hpp"

namespace waymark {
namespace {

using namespace test;  // NOLINT(google-build-using-namespace): the robot's parts

double yaw_sigma(const Belief& belief) { return std::sqrt(belief.P(2, 2)); }

TEST(FusionStandstill, TenMinutesOfStandstillLeaveTheHeadingAsCertainAsItWas) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels + gps());
  std::vector<Measurement> log;
  drive(log, 0.0, 5.0, 1.0);
  drive(log, 5.0, 606.0, 0.0);
  for (int k = 0; k < 5; ++k) log.push_back(fix(k, k, 0.0));
  robot.play(in_order(log));
  const auto at_stamp = [&](double stamp) {
    return std::find_if(robot.seen().begin(), robot.seen().end(),
                        [&](const Seen& s) { return std::abs(s.stamp - stamp) < 1e-6; })
        ->belief;
  };
  const Belief begin = at_stamp(5.6);
  const Belief end = at_stamp(605.6);
  ASSERT_GT(yaw_sigma(begin), 0.0);
  EXPECT_NEAR(yaw_sigma(end) / yaw_sigma(begin), 1.0, 0.01);
  EXPECT_NEAR(std::sqrt(end.P(0, 0) / begin.P(0, 0)), 1.0, 0.01);
  EXPECT_EQ(end.mean.T_map_base.p, begin.mean.T_map_base.p);
  EXPECT_EQ(end.mean.v_base, Eigen::Vector3d::Zero());
}

TEST(FusionStandstill, BeginsHalfASecondAfterTheLastMotion) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels);
  std::vector<Measurement> log;
  drive(log, 0.0, 1.0, 1.0);
  drive(log, 1.0, 2.0, 0.0);
  robot.play(in_order(log));
  for (const Seen& seen : robot.seen()) {
    EXPECT_EQ(seen.belief.P(3, 3) == 0.0, seen.stamp > 1.35) << seen.stamp;  // the last motion was at 0.9 s
  }
}

/// Reports no motion, whatever the robot does: an IMU on a smooth drive.
class FeelsAtRest final : public Sensor {
 public:
  SensorTraits traits() const override { return {.is_motion_source = true}; }
  void process(const Measurement&, const Prediction&, UpdateList& out) override { out.report_motion(false); }
  std::unique_ptr<Sensor> clone() const override { return std::make_unique<FeelsAtRest>(*this); }
};

TEST(FusionStandstill, WheelsThatFailWhileTheyTurnDoNotStopTheRobot) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels + "  - { name: rest, plugin: rest }\n",
                    {{"rest", std::make_shared<FeelsAtRest>()}});
  std::vector<Measurement> log;
  drive(log, 0.0, 5.0, 1.0);
  for (int k = 0; k < 100; ++k) log.push_back(twist(0.1 * k + 0.05, 0.0, 0.0, 1));
  robot.play(in_order(log));
  EXPECT_NEAR(robot.filter().mixture().mean.v_base.x(), 1.0, 0.1);
  EXPECT_NEAR(robot.pose().p.x(), 9.9, 1.0);
}

TEST(FusionStandstill, TheRobotStartsAgain) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels);
  std::vector<Measurement> log;
  drive(log, 0.0, 60.0, 0.0);
  drive(log, 60.0, 70.0, 1.0);
  robot.play(in_order(log));
  EXPECT_NEAR(robot.filter().mixture().mean.v_base.x(), 1.0, 0.05);
  EXPECT_NEAR(robot.pose().p.x(), 9.9, 0.1);  // from the first twist at 60.0 to the last at 69.9
  EXPECT_EQ(robot.report(0).gated, 0U);
}

TEST(Fusion, DrivesAsTheWheelsMeasure) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels);
  std::vector<Measurement> log;
  drive(log, 0.0, 20.0, 1.0, 0.1, 50.0);
  robot.play(in_order(log));
  const double turned = 0.1 * 19.98;
  EXPECT_NEAR(robot.pose().yaw(), turned, 0.02);
  EXPECT_NEAR(robot.pose().p.x(), 10.0 * std::sin(turned), 0.2);
  EXPECT_NEAR(robot.pose().p.y(), 10.0 * (1.0 - std::cos(turned)), 0.2);
}

// Between two samples the unknown acceleration q adds q² dt²/12 per second to the position's variance at most, against
// density² by the wheels. With q = 1, dt = 0.04 s and a density of 0.1 that is 1.3 %; the transient of the unknown
// first twist gives the rest of the bound.
TEST(Fusion, HalvingTheOdometryRateDoesNotChangeThePoseCovariance) {
  const std::string yaml =
      kAtOrigin +
      "motion: { velocity_noise_mps_per_sqrt_s: [1, 1, 1], rate_noise_radps_per_sqrt_s: [1, 1, 1] }\nsensors:\n" +
      "  - { name: wheels, plugin: odometry, model: twist, speed_noise_m_per_sqrt_s: [0.1, 0], "
      "lateral_noise_m_per_sqrt_s: [0.1, 0], yaw_noise_rad_per_sqrt_s: [0.1, 0, 0], " +
      kNoStates + " }\n";
  const auto covariance = [&](double rate) {
    FusionRobot robot(yaml);
    std::vector<Measurement> log;
    drive(log, 0.0, 60.0, 0.5, 0.0, rate);
    log.push_back(twist(60.0, 0.5));
    robot.play(in_order(log));
    return robot.pose_P();
  };
  const Eigen::Matrix3d full = covariance(50.0);
  const Eigen::Matrix3d half = covariance(25.0);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(half(i, i) / full(i, i), 1.0, 0.03) << i;
  // And it equals the density: 0.1 m/√s over a minute.
  EXPECT_NEAR(full(0, 0), 0.01 * 60.0, 0.05 * 0.6);
}

/// Ten seconds of a curve with fixes that scatter.
std::vector<Measurement> curve() {
  std::vector<Measurement> log;
  Random random = stream(41);
  drive(log, 0.0, 10.0, 1.0, 0.2);
  for (int k = 0; k < 20; ++k) {
    const double t = 0.5 * k;
    const double east = 5.0 * std::sin(0.2 * t) + 0.1 * random.normal();
    const double north = 5.0 * (1.0 - std::cos(0.2 * t)) + 0.1 * random.normal();
    log.push_back(fix(t, east, north));
  }
  return in_order(log);
}

std::string windowed(const std::string& filter) {
  return kAtOrigin + "filter: " + filter + "\nsensors:\n" + kWheels + gps();
}

TEST(FusionOrder, TheCommittedResultDoesNotDependOnTheOrderOfArrival) {
  const std::string yaml = windowed("{ max_latency_s: 0.5, particles: 10 }");
  FusionRobot ideal(yaml);
  ideal.play(curve());
  Random random = stream(42);
  for (int trial = 0; trial < 5; ++trial) {
    std::vector<Measurement> delayed = curve();
    for (Measurement& m : delayed) m.arrival = m.stamp + from_seconds(uniform(random, 0.0, 0.5));
    std::stable_sort(delayed.begin(), delayed.end(),
                     [](const auto& a, const auto& b) { return a.arrival < b.arrival; });
    FusionRobot robot(yaml);
    robot.play(delayed);
    EXPECT_EQ(robot.bytes(), ideal.bytes());
    ASSERT_EQ(robot.seen().size(), ideal.seen().size());
    for (std::size_t i = 0; i < ideal.seen().size(); ++i) {
      ASSERT_EQ(robot.seen()[i].stamp, ideal.seen()[i].stamp);
      ASSERT_EQ(robot.seen()[i].belief.P, ideal.seen()[i].belief.P);
    }
  }
}

TEST(FusionOrder, WhatIsOlderThanTheWindowIsCountedAsLate) {
  FusionRobot robot(windowed("{ max_latency_s: 0.2 }"));
  FusionRobot without(windowed("{ max_latency_s: 0.2 }"));
  std::vector<Measurement> log = curve();
  without.play(log);
  Measurement late = fix(3.0, 500.0, 500.0);
  late.arrival = at(9.9);
  late.sequence = 1000;
  log.push_back(late);
  robot.play(log);
  EXPECT_EQ(robot.report(1).late, 1U);
  EXPECT_EQ(robot.report(1).measurements, 21U);
  EXPECT_EQ(robot.bytes(), without.bytes());
}

TEST(FusionOrder, WithoutLatencyEverythingIsCommittedInOrder) {
  FusionRobot robot(windowed("{ max_latency_s: 0 }"));
  robot.play(curve());
  EXPECT_EQ(robot.report(0).fused + robot.report(1).fused, 120U);
  EXPECT_EQ(robot.report(0).late + robot.report(1).late, 0U);
}

TEST(FusionFront, AppliesWhatIsNotYetCommitted) {
  FusionRobot robot(windowed("{ max_latency_s: 2.0 }"));
  for (const Measurement& m : curve()) robot.fusion().add(m);
  const Time last = at(9.9);
  const Time committed = robot.filter().stamp();
  ASSERT_LT(committed, at(8.0));
  const Belief front = robot.fusion().front(last);
  EXPECT_EQ(robot.filter().stamp(), committed) << "the committed side was touched";
  robot.fusion().finish();
  const Belief& mixture = robot.filter().mixture();
  EXPECT_EQ(front.stamp, mixture.stamp);
  EXPECT_LT(boxminus(front.mean, mixture.mean, robot.fusion().layout()).norm(), 1e-12);
  EXPECT_LT((front.P - mixture.P).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(FusionFront, EqualsTheCommittedResultOnceAllIsCommitted) {
  FusionRobot robot(windowed("{ max_latency_s: 0.5, particles: 10 }"));
  robot.play(curve());
  const Belief& mixture = robot.filter().mixture();
  const Belief front = robot.fusion().front(mixture.stamp);
  EXPECT_EQ(front.P, mixture.P);
  EXPECT_EQ(front.mean.T_map_base.p, mixture.mean.T_map_base.p);
}

TEST(FusionFront, PredictsToTheTimeAsked) {
  FusionRobot robot(windowed("{ max_latency_s: 0.5 }"));
  robot.play(curve());
  const Belief now = robot.fusion().front(at(9.9));
  const Belief later = robot.fusion().front(at(10.9));
  EXPECT_NEAR((later.mean.T_map_base.p - now.mean.T_map_base.p).norm(), 1.0, 0.1);
  EXPECT_GT(later.P(0, 0), now.P(0, 0));
}

TEST(FusionFront, OfAnotherThreadAgreesWithTheFilter) {
  FusionRobot robot(windowed("{ max_latency_s: 0 }"));
  const std::vector<Measurement> log = curve();
  const std::size_t half = log.size() / 2;
  for (std::size_t i = 0; i < half; ++i) robot.fusion().add(log[i]);
  const std::unique_ptr<Front> front = robot.fusion().front();
  ASSERT_NE(front, nullptr);
  for (const Measurement& m : log) {
    if (m.stamp > robot.filter().stamp()) front->add(m);  // those of the queue, too
  }
  for (std::size_t i = half; i < log.size(); ++i) robot.fusion().add(log[i]);
  robot.fusion().finish();
  const Belief& mixture = robot.filter().mixture();
  const Belief ahead = front->at(mixture.stamp);
  EXPECT_LT(boxminus(ahead.mean, mixture.mean, robot.fusion().layout()).norm(), 1e-9);
  EXPECT_LT((ahead.P - mixture.P).cwiseAbs().maxCoeff(), 1e-9);
  front->add(log.front());  // older: the filter's part
  EXPECT_EQ(front->at(mixture.stamp).P, ahead.P);
}

TEST(FusionFront, IsNoneBeforeTheStart) {
  FusionRobot robot(windowed("{ max_latency_s: 0.5 }"));
  EXPECT_EQ(robot.fusion().front(), nullptr);
}

TEST(FusionModes, AShadowIsEvaluatedAndDoesNotSteer) {
  const std::string yaml = kAtOrigin + "sensors:\n" + kWheels + gps();
  const std::vector<Measurement> log = curve();
  FusionRobot off(yaml);
  off.fusion().set_mode(1, SensorMode::off);
  off.play(log);
  FusionRobot shadow(yaml);
  shadow.fusion().set_mode(1, SensorMode::shadow);
  shadow.play(log);
  EXPECT_EQ(shadow.pose_P(), off.pose_P());
  EXPECT_EQ(shadow.pose().p, off.pose().p);
  EXPECT_EQ(off.report(1).nis_count, 0U);
  EXPECT_EQ(off.report(1).held_out, off.report(1).measurements);
  EXPECT_EQ(shadow.report(1).nis_count, shadow.report(1).measurements);
  EXPECT_EQ(shadow.report(1).held_out, shadow.report(1).measurements);
}

TEST(FusionModes, SteersAgainWhenItIsFused) {
  const std::vector<Measurement> log = curve();
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels + gps());
  robot.fusion().set_mode(1, SensorMode::off);
  for (std::size_t i = 0; i < log.size(); ++i) {
    if (i == log.size() / 2) robot.fusion().set_mode(1, SensorMode::fused);
    robot.fusion().add(log[i]);
  }
  EXPECT_EQ(robot.fusion().mode(1), SensorMode::fused);
  EXPECT_GT(robot.report(1).fused, 5U);
  EXPECT_GT(robot.report(1).held_out, 5U);
}

TEST(FusionSetPose, BeginsAnewThereAndLaterMeasurementsGoOn) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels);
  robot.fusion().add(twist(0.0, 1.0));
  robot.fusion().add(twist(1.0, 0.0));
  robot.fusion().set_pose({{10.0, 20.0}, 0.5 * std::numbers::pi, 0.3, 0.1});
  robot.fusion().add(twist(1.1, 0.0));
  const Belief& belief = robot.filter().mixture();
  EXPECT_NEAR(belief.mean.T_map_base.p.x(), 10.0, 0.4);
  EXPECT_NEAR(belief.mean.T_map_base.p.y(), 20.0, 0.4);
  EXPECT_NEAR(belief.mean.T_map_base.yaw(), 0.5 * std::numbers::pi, 0.15);
  EXPECT_NEAR(std::sqrt(belief.P(0, 0)), 0.3, 0.1);
  EXPECT_NE(robot.events().find("the pose was set"), std::string::npos);
}

TEST(FusionSetPose, RefusesWhatIsNoPose) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels);
  robot.fusion().add(twist(0.0, 1.0));
  EXPECT_THROW(robot.fusion().set_pose({{std::nan(""), 0.0}, 0.0, 0.3, 0.1}), Error);
  EXPECT_THROW(robot.fusion().set_pose({{0.0, std::nan("")}, 0.0, 0.3, 0.1}), Error);
  EXPECT_THROW(robot.fusion().set_pose({{0.0, 0.0}, 0.0, 0.0, 0.1}), Error);
  EXPECT_THROW(robot.fusion().set_pose({{0.0, 0.0}, 0.0, 1e-300, 0.1}), Error) << "its square is 0";
  EXPECT_THROW(robot.fusion().set_pose({{0.0, 0.0}, 0.0, 1e200, 0.1}), Error) << "its square is infinite";
  EXPECT_THROW(robot.fusion().set_pose({{0.0, 0.0}, 0.0, 0.3, 1e200}), Error);
  EXPECT_THROW(robot.fusion().set_pose({{1e300, 0.0}, 0.0, 0.3, 0.1}), Error);
  EXPECT_THROW(robot.fusion().set_pose({{0.0, 0.0}, HUGE_VAL, 0.3, 0.1}), Error);
  EXPECT_NO_THROW(robot.fusion().set_pose({{1e6, -1e6}, 1e3, 0.3, 0.1}));
}

TEST(Fusion, ReportsTheLastMeasurementAgain) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels);
  int calls = 0;
  robot.fusion().visit_last([&](const Snapshot&) { ++calls; });
  EXPECT_EQ(calls, 0);
  robot.play({twist(0.0, 1.0)});
  robot.fusion().visit_last([&](const Snapshot& s) { calls += s.stamp() == at(0.0) ? 1 : 0; });
  EXPECT_EQ(calls, 1);
}

}  // namespace
}  // namespace waymark
