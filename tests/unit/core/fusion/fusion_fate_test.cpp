// SPDX-License-Identifier: Apache-2.0
// needs plugins: dgps, odometry
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "unit/core/fusion_robot.hpp"
#include "unit/core/toy_map.hpp"

namespace waymark {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using namespace test;  // NOLINT(google-build-using-namespace): the robot's parts

/// A robot that drives east at 1 m/s for 40 s, with a true fix every second.
std::vector<Measurement> forty_seconds() {
  std::vector<Measurement> log;
  drive(log, 0.0, 40.0, 1.0);
  for (int k = 0; k < 40; ++k) log.push_back(fix(k, k, 0.0));
  return in_order(log);
}

SensorReport gps_report(const std::string& rule) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels + gps(rule));
  return robot.play(forty_seconds()).report(1);
}

TEST(FusionHeldOut, AllFusesEverything) {
  const SensorReport report = gps_report("fuse: all");
  EXPECT_EQ(report.fused, 40U);
  EXPECT_EQ(report.held_out, 0U);
}

TEST(FusionHeldOut, NoneHoldsEverythingOut) {
  const SensorReport report = gps_report("fuse: none");
  EXPECT_EQ(report.fused, 0U);
  EXPECT_EQ(report.held_out, 40U);
}

TEST(FusionHeldOut, StartUsesTheFirstFixOnly) {
  FusionRobot robot("initial: { yaw_deg: 0 }\nsensors:\n" + kWheels + gps("fuse: start"));
  robot.play(forty_seconds());
  EXPECT_EQ(robot.report(1).fused, 1U);
  EXPECT_EQ(robot.report(1).held_out, 39U);
  EXPECT_EQ(robot.report(0).fused, 400U);
}

TEST(FusionHeldOut, AlternateTakesTurnsFromTheFirstMeasurement) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels + gps("fuse: alternate, fuse_on_s: 10, fuse_off_s: 5"));
  robot.play(forty_seconds());
  for (const Seen& seen : robot.seen()) {
    if (seen.sensor != 1) continue;
    EXPECT_EQ(seen.fate, std::fmod(seen.stamp, 15.0) < 10.0 ? Fate::fused : Fate::held_out) << seen.stamp;
  }
  EXPECT_EQ(robot.report(1).fused, 30U);
}

TEST(FusionHeldOut, StretchesTakesEverySecondOne) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels + gps("fuse: stretches, fuse_gap_s: 2"));
  std::vector<Measurement> log;
  drive(log, 0.0, 40.0, 1.0);
  for (const int k : {0, 1, 2, 10, 11, 12, 13, 20, 21, 30}) log.push_back(fix(k, k, 0.0));
  robot.play(in_order(log));
  EXPECT_EQ(robot.report(1).fused, 5U);
  EXPECT_EQ(robot.report(1).held_out, 5U);
}

TEST(FusionHeldOut, WhatIsHeldOutDoesNotTouchTheBelief) {
  FusionRobot with(kAtOrigin + "sensors:\n" + kWheels + gps("fuse: none"));
  FusionRobot without(kAtOrigin + "sensors:\n" + kWheels);
  std::vector<Measurement> wrong;
  drive(wrong, 0.0, 5.0, 1.0);
  const std::vector<Measurement> wheels_only = in_order(wrong);
  for (int k = 0; k < 5; ++k) wrong.push_back(fix(k, 1000.0, 1000.0));
  with.play(in_order(wrong));
  without.play(wheels_only);
  EXPECT_EQ(with.pose().p, without.pose().p);
}

/// Throws at its n-th measurement; DataError or something else.
class Breaking final : public Sensor {
 public:
  Breaking(int at, bool data_error) : at_(at), data_error_(data_error) {}
  void process(const Measurement&, const Prediction&, UpdateList&) override {
    if (++count_ != at_) return;
    if (data_error_) throw DataError("a broken reading");
    throw std::runtime_error("the toy broke");
  }
  std::unique_ptr<Sensor> clone() const override { return std::make_unique<Breaking>(*this); }

 private:
  int at_;
  bool data_error_;
  int count_ = 0;
};

std::vector<Measurement> toy_log() {
  std::vector<Measurement> log;
  drive(log, 0.0, 10.0, 1.0);
  for (int k = 0; k < 10; ++k) log.push_back(reading(k, 1, std::make_shared<BodyTwist>()));
  return in_order(log);
}

TEST(FusionFaults, ASensorThatThrowsIsTakenOutOfServiceAndTheRunContinues) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels + "  - { name: toy, plugin: toy }\n",
                    {{"toy", std::make_shared<Breaking>(4, false)}});
  robot.play(toy_log());
  EXPECT_THAT(robot.events(), HasSubstr("toy: taken out of service: the toy broke"));
  EXPECT_EQ(robot.report(1).fused, 3U);
  EXPECT_EQ(robot.report(1).ignored, 7U);
  EXPECT_EQ(robot.report(0).fused, 100U);
  EXPECT_NEAR(robot.pose().p.x(), 9.9, 0.2);
}

/// Throws from `start_hint`.
class BreakingHint final : public Sensor {
 public:
  SensorTraits traits() const override { return {.is_absolute = true}; }
  std::optional<StartHint> start_hint(const Measurement&, const Datum*) const override {
    throw std::runtime_error("the hint broke");
  }
  void process(const Measurement&, const Prediction&, UpdateList&) override {}
  std::unique_ptr<Sensor> clone() const override { return std::make_unique<BreakingHint>(*this); }
};

TEST(FusionFaults, ASensorThatThrowsBeforeTheStartIsTakenOutOfServiceToo) {
  FusionRobot robot("sensors:\n" + kWheels + gps() + "  - { name: toy, plugin: toy }\n",
                    {{"toy", std::make_shared<BreakingHint>()}});
  std::vector<Measurement> log;
  drive(log, 0.0, 10.0, 1.0);
  for (int k = 0; k < 10; ++k) log.push_back(fix(k, k, 0.0));
  for (int k = 0; k < 10; ++k) log.push_back(reading(k, 2, std::make_shared<BodyTwist>()));
  robot.play(in_order(log));
  EXPECT_THAT(robot.events(), HasSubstr("toy: taken out of service: the hint broke"));
  EXPECT_TRUE(robot.fusion().started());
}

/// Of two maps with the same trigger this one rejects every measurement, or throws something that is not an exception.
class RejectingMap final : public MapModule {
 public:
  explicit RejectingMap(bool breaks) : breaks_(breaks) {}
  std::unique_ptr<ParticleMap> create_map() const override { return std::make_unique<ToyMap>(ToyMap::Fails::never); }
  std::shared_ptr<const Observation> extract(const Measurement&, std::span<const Companion>,
                                             const MotionWindow&) override {
    if (breaks_) throw 7;
    throw DataError("an empty scan");
  }
  std::unique_ptr<ParticleMap> load_map(InArchive& in) const override { return ToyMap::load(in); }

 private:
  bool breaks_;
};

std::string events_with(bool breaks) {
  std::vector<MapSlot> maps(2);
  maps[0].name = "rejecting";
  maps[0].module = std::make_shared<RejectingMap>(breaks);
  maps[1].name = "fine";
  maps[1].module = std::make_shared<ToyModule>();
  for (MapSlot& map : maps) map.inputs = {1};
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels + "  - { name: scanner, payload: LaserScan }\n", {}, maps);
  robot.play(toy_log());
  EXPECT_EQ(robot.report(1).mapped, 10U);
  return robot.events();
}

TEST(FusionFaults, AMeasurementThatOneOfTwoMapsRejectsIsReportedOnce) {
  const std::string events = events_with(false);
  const std::size_t first = events.find("rejecting: an empty scan");
  ASSERT_NE(first, std::string::npos) << events;
  EXPECT_EQ(events.find("an empty scan", first + 20), std::string::npos) << events;
  EXPECT_THAT(events, HasSubstr("rejecting: 10 measurements were unusable"));
}

TEST(FusionFaults, AMapThatThrowsWhatIsNoExceptionIsTakenOutOfService) {
  EXPECT_THAT(events_with(true), HasSubstr("map rejecting: taken out of service: unknown exception"));
}

TEST(FusionFaults, BadDataIsCountedAndTheSensorStays) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels + "  - { name: toy, plugin: toy }\n",
                    {{"toy", std::make_shared<Breaking>(4, true)}});
  robot.play(toy_log());
  EXPECT_THAT(robot.events(), HasSubstr("toy: a broken reading"));
  EXPECT_THAT(robot.events(), Not(HasSubstr("out of service")));
  EXPECT_EQ(robot.report(1).unusable, 1U);
  EXPECT_EQ(robot.report(1).fused, 9U);
}

TEST(FusionFaults, AWrongPayloadIsUnusable) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels);
  robot.play(in_order({twist(0.0, 1.0), reading(0.1, 0, std::make_shared<GnssFix>()), twist(0.2, 1.0)}));
  EXPECT_EQ(robot.report(0).unusable, 1U);
  EXPECT_EQ(robot.report(0).fused, 2U);
  EXPECT_THAT(robot.events(), HasSubstr("waymark/GnssFix@1"));
}

TEST(FusionFaults, AReadingThatIsNotFiniteNeverReachesTheFilter) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels);
  robot.play(in_order({twist(0.0, 1.0), twist(0.1, std::nan("")), twist(0.2, 1.0)}));
  EXPECT_EQ(robot.report(0).unusable, 1U);
  EXPECT_TRUE(robot.filter().mixture().P.allFinite());
  EXPECT_TRUE(robot.pose().p.allFinite());
}

TEST(FusionFaults, ASensorWithoutPluginIsReportedOnce) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels + "  - { name: lidar, payload: LaserScan }\n");
  robot.play(toy_log());
  EXPECT_EQ(robot.report(1).ignored, 10U);
  EXPECT_EQ(robot.fusion().report().events.size(), 1U);
}

// The gate alone, without the receiver's own monitoring before it.
TEST(FusionGate, AFixFarOffIsGatedAndLeavesTheBeliefAlone) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels + gps("jump_sigmas: 0"));
  std::vector<Measurement> log = forty_seconds();
  log.push_back(fix(39.95, 500.0, 0.0));
  robot.play(in_order(log));
  EXPECT_EQ(robot.report(1).gated, 1U);
  EXPECT_NEAR(robot.pose().p.x(), 39.95, 0.5);
}

/// The wheels turn a third too fast from 20 s on; every fix is good.
std::vector<Measurement> slip_from_20() {
  std::vector<Measurement> log;
  drive(log, 0.0, 20.0, 1.0);
  drive(log, 20.0, 30.0, 1.3);
  drive(log, 30.0, 60.0, 1.0);
  for (int k = 0; k < 240; ++k) log.push_back(fix(0.25 * k, 0.25 * k, 0.0));
  return in_order(log);
}

TEST(FusionBias, WheelsThatSlipDoNotCarryTheBeliefAwayFromTheFixes) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels + gps("jump_sigmas: 0"));
  robot.play(slip_from_20());
  EXPECT_THAT(robot.events(), HasSubstr("gps: its innovations are biased"));
  EXPECT_NEAR(robot.pose().p.x(), 60.0, 0.3);
  int off = 0;
  for (const Seen& seen : robot.seen()) {
    if (seen.stamp < 35.0 || seen.belief.P.size() == 0) continue;
    off += std::abs(seen.belief.mean.T_map_base.p.x() - seen.stamp) > 0.5;
  }
  EXPECT_EQ(off, 0);
}

TEST(FusionBias, IsNotSeenWhereNothingIsWrong) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels + gps("jump_sigmas: 0"));
  robot.play(in_order(forty_seconds()));
  EXPECT_EQ(robot.events(), "");
}

/// An attitude that is off by the same angles each time, inside of its gate.
class TurnedAttitude final : public Update {
 public:
  void linearize(const StateView&, Linearization& out) const override {
    out.reset(3, 0);
    out.residual.setConstant(0.02);
    out.R = 0.01 * 0.01 * Eigen::Matrix3d::Identity();
    out.attitude().setIdentity();
  }
  Quantity observes() const override { return Quantity::attitude; }
};

class TurnedSensor final : public Sensor {
 public:
  SensorTraits traits() const override { return {.is_absolute = true}; }
  void process(const Measurement&, const Prediction&, UpdateList& out) override { out.emplace<TurnedAttitude>(); }
  std::unique_ptr<Sensor> clone() const override { return std::make_unique<TurnedSensor>(*this); }
};

TEST(FusionBias, RadiansAreNotTakenForMetres) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels + "  - { name: attitude, plugin: turned }\n",
                    {{"turned", std::make_shared<TurnedSensor>()}});
  std::vector<Measurement> log;
  drive(log, 0.0, 20.0, 1.0);
  for (int k = 0; k < 20; ++k) log.push_back(reading(k + 0.05, 1, std::make_shared<BodyTwist>()));
  robot.play(in_order(log));
  EXPECT_EQ(robot.report(1).fused, 20U) << "the gate does not hide it";
  EXPECT_THAT(robot.events(), Not(HasSubstr("biased")));
}

/// A sensor with one state of its own.
class OwnState final : public Sensor {
 public:
  StateBlock block() const override {
    BlockState state;
    state.name = "scale";
    state.initial_sigma = 0.1;
    return {state};
  }
  void process(const Measurement&, const Prediction&, UpdateList&) override {}
  std::unique_ptr<Sensor> clone() const override { return std::make_unique<OwnState>(*this); }
};

TEST(FusionGeoreference, ASensorOfThatNameIsASensor) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels + "  - { name: georeference, plugin: own }\n",
                    {{"own", std::make_shared<OwnState>()}});
  EXPECT_EQ(robot.fusion().georeference_states(), 0);
  EXPECT_EQ(robot.fusion().layout().block_size(), 1);
  std::vector<Measurement> log;
  drive(log, 0.0, 2.0, 1.0);
  robot.play(in_order(log));
  EXPECT_NEAR(robot.pose().p.x(), 2.0, 0.2);
}

/// Detects two known landmarks from the robot's true pose: it drives east with 1 m/s.
class Surveyed final : public MapModule {
 public:
  std::unique_ptr<ParticleMap> create_map() const override { return std::make_unique<ToyMap>(ToyMap::Fails::never); }
  std::shared_ptr<const Observation> extract(const Measurement& trigger, std::span<const Companion>,
                                             const MotionWindow&) override {
    auto sighting = std::make_shared<test::Sighting>();
    const Pose truth = Pose::planar(to_seconds(trigger.stamp.time_since_epoch()), 0.0, 0.0);
    for (const Eigen::Vector2d& p_map : {Eigen::Vector2d(30, 5), Eigen::Vector2d(-8, 7)})
      sighting->see(truth, p_map, Eigen::Vector2d::Zero());
    return sighting;
  }
  std::unique_ptr<ParticleMap> load_map(InArchive& in) const override { return ToyMap::load(in); }
};

TEST(FusionBias, DriftingFixesDoNotTearParticlesFromTheirMaps) {
  MapSlot slot;
  slot.name = "surveyed";
  slot.module = std::make_shared<Surveyed>();
  slot.inputs = {2};
  FusionRobot robot(kAtOrigin + "georeference: { enabled: false }\nfilter: { particles: 2 }\nsensors:\n" + kWheels +
                        gps("jump_sigmas: 0") + "  - { name: scanner, payload: LaserScan }\n",
                    {}, {slot});
  std::vector<Measurement> log;
  drive(log, 0.0, 60.0, 1.0);
  for (int k = 0; k < 60; ++k) log.push_back(fix(k + 0.05, k + 0.05, k < 10 ? 0.0 : 0.5));
  for (int k = 0; k < 60; ++k) log.push_back(reading(k + 0.5, 2, std::make_shared<BodyTwist>()));
  robot.play(in_order(log));
  EXPECT_THAT(robot.events(), HasSubstr("gps: its innovations are biased"));
  EXPECT_THAT(robot.events(), Not(HasSubstr("inflated")));
  for (const Seen& seen : robot.seen()) {
    if (seen.stamp <= 5.0) continue;
    // The report has the contradiction between fixes and map in it, half a metre, and their own noise.
    EXPECT_LT(pose_covariance(seen.belief, robot.fusion().layout())(1, 1), 0.36) << seen.stamp;
  }
  EXPECT_LT(pose_covariance(robot.filter().mixture(), robot.fusion().layout())(1, 1), 0.03);
}

}  // namespace
}  // namespace waymark
