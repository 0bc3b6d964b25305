// SPDX-License-Identifier: Apache-2.0
// needs plugins: dgps, imu, odometry
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "unit/core/fusion_robot.hpp"
#include "unit/core/toy_map.hpp"

namespace waymark {
namespace {

using ::testing::HasSubstr;
using namespace test;  // NOLINT(google-build-using-namespace): the robot's parts

constexpr double kDeg = std::numbers::pi / 180.0;

TEST(FusionStart, FromTheYamlAtTheFirstMeasurement) {
  FusionRobot robot("initial: { x_m: 3, y_m: 4, z_m: 2, yaw_deg: 90 }\nsensors:\n" + kWheels);
  EXPECT_FALSE(robot.fusion().started());
  robot.play({twist(0.0, 0.0)});
  EXPECT_TRUE(robot.fusion().started());
  EXPECT_EQ(robot.pose().p, Eigen::Vector3d(3.0, 4.0, 2.0));
  EXPECT_NEAR(robot.pose().yaw(), 90.0 * kDeg, 1e-12);
}

TEST(FusionStart, WithoutAnAbsoluteSensorThePoseIsTheGaugeAndCertain) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels);
  robot.play({twist(0.0, 0.0)});
  EXPECT_TRUE(robot.pose_P().isZero(0.0));
}

TEST(FusionStart, WithAnAbsoluteSensorThePoseHasTheUncertaintyOfTheYaml) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels + gps());
  robot.play({twist(0.0, 0.0)});
  EXPECT_NEAR(robot.pose_P()(0, 0), 0.01, 1e-12);
  EXPECT_NEAR(robot.pose_P()(2, 2), 25.0 * kDeg * kDeg, 1e-12);
}

TEST(FusionStart, AtAPoseThatIsGivenBeforeInPlaceOfWhatTheSensorsFind) {
  FusionRobot robot("sensors:\n" + kWheels + gps());
  robot.play({fix(0.0, 5.0, 6.0, 1)});
  EXPECT_FALSE(robot.fusion().started()) << "the heading is not known";
  robot.fusion().set_pose({{1.0, 2.0}, 30.0 * kDeg, 0.2, 0.1});
  robot.play({twist(0.1, 0.0)});
  ASSERT_TRUE(robot.fusion().started());
  EXPECT_NEAR(robot.pose().p.x(), 1.0, 1e-9);
  EXPECT_NEAR(robot.pose().p.y(), 2.0, 1e-9);
  EXPECT_NEAR(robot.pose().yaw(), 30.0 * kDeg, 1e-9);
  EXPECT_NEAR(robot.pose_P()(0, 0), 0.04, 1e-9);
}

std::string antenna(const std::string& name, const std::string& place) {
  return "  - { name: " + name + ", plugin: dgps, base_p_antenna_m: [" + place +
         ", 0], sigma_m: 0.05, offset_sigma_m: 0 }\n";
}

TEST(FusionStart, TwoAntennasAtStandstillAreNoCourse) {
  FusionRobot robot("sensors:\n" + kWheels + antenna("left", "0, 0.6") + antenna("right", "0, -0.6"));
  std::vector<Measurement> log;
  drive(log, 0.0, 5.0, 0.0);
  drive(log, 5.0, 20.0, 1.0);
  for (int k = 0; k < 20; ++k) {
    const double x = std::max(0.0, k - 5.0);
    log.push_back(fix(k, x, 0.6, 1));
    log.push_back(fix(k, x, -0.6, 2));
  }
  robot.play(in_order(log));
  ASSERT_TRUE(robot.fusion().started());
  EXPECT_NEAR(robot.pose().yaw(), 0.0, 5.0 * kDeg);
  EXPECT_EQ(robot.report(1).gated + robot.report(2).gated, 0U);
}

TEST(FusionStart, TwoAntennasGiveTheHeadingAtStandstill) {
  FusionRobot robot("sensors:\n" + kWheels + antenna("left", "0, 0.6") + antenna("right", "0, -0.6"));
  std::vector<Measurement> log;
  drive(log, 0.0, 5.0, 0.0);
  for (int k = 0; k < 5; ++k) {  // it looks to the north, so that its left is in the west
    log.push_back(fix(k, -0.6, 0.0, 1));
    log.push_back(fix(k, 0.6, 0.0, 2));
  }
  robot.play(in_order(log));
  ASSERT_TRUE(robot.fusion().started());
  EXPECT_NEAR(robot.pose().yaw(), 90.0 * kDeg, 5.0 * kDeg);
}

/// Fixes five times a second of a robot that goes with `v` and `w` for `span` seconds, the antenna at `arm` ahead.
std::vector<Measurement> driven(double yaw, double v, double w, double span, double arm = 0.0) {
  std::vector<Measurement> log;
  drive(log, 0.0, span, v, w, 50.0);
  for (int k = 0; k < static_cast<int>(5.0 * span); ++k) {
    const double t = 0.2 * k;
    const double now = yaw + w * t;
    const double chord = w == 0.0 ? t : std::sin(0.5 * w * t) / (0.5 * w);
    const double along = yaw + 0.5 * w * t;
    log.push_back(
        fix(t, v * chord * std::cos(along) + arm * std::cos(now), v * chord * std::sin(along) + arm * std::sin(now)));
  }
  return in_order(log);
}

double off(double yaw, double from) { return std::remainder(yaw - from, 2.0 * std::numbers::pi); }

TEST(FusionStart, HeadingIsFoundInACurve) {
  // Three quarters of a circle of 1.5 m: the chord is far from the heading everywhere.
  FusionRobot robot("sensors:\n" + kWheels + gps("sigma_vertical_m: 0.2"));
  robot.play(driven(0.5, 1.2, 0.8, 6.0));
  ASSERT_TRUE(robot.fusion().started());
  const Seen& first = *std::ranges::find_if(robot.seen(), [](const Seen& seen) { return seen.belief.P.size() > 0; });
  EXPECT_NEAR(off(first.belief.mean.T_map_base.yaw(), 0.5 + 0.8 * first.stamp), 0.0, 3.0 * kDeg);
  EXPECT_NEAR(off(robot.pose().yaw(), 0.5 + 0.8 * 6.0), 0.0, 3.0 * kDeg);
}

TEST(FusionStart, HeadingIsFoundInReverse) {
  FusionRobot robot("sensors:\n" + kWheels + gps());
  robot.play(driven(2.0, -1.0, 0.0, 4.0));
  ASSERT_TRUE(robot.fusion().started());
  EXPECT_NEAR(off(robot.pose().yaw(), 2.0), 0.0, 3.0 * kDeg);
}

TEST(FusionStart, HeadingIsFoundWhileTheRobotTurnsInPlaceIfTheAntennaIsOffTheAxle) {
  FusionRobot robot(
      "sensors:\n" + kWheels +
      "  - { name: gps, plugin: dgps, base_p_antenna_m: [0.8, 0, 1], sigma_m: 0.1, offset_sigma_m: 0 }\n");
  robot.play(driven(-1.0, 0.0, 0.5, 8.0, 0.8));
  ASSERT_TRUE(robot.fusion().started());
  EXPECT_NEAR(off(robot.pose().yaw(), -1.0 + 0.5 * 8.0), 0.0, 6.0 * kDeg);
}

TEST(FusionStart, HeadingIsFoundAfterMinutesAtStandstill) {
  std::vector<Measurement> log;
  drive(log, 0.0, 600.0, 0.0);
  drive(log, 600.0, 604.0, -1.0);
  for (int k = 0; k < 604; ++k) log.push_back(fix(k + 0.5, -std::max(0.0, k + 0.5 - 600.0), k % 2 == 0 ? 0.05 : -0.05));
  FusionRobot robot("sensors:\n" + kWheels + gps());
  robot.play(in_order(log));
  ASSERT_TRUE(robot.fusion().started());
  EXPECT_NEAR(robot.pose().yaw(), 0.0, 6.0 * kDeg);
}

TEST(FusionStart, HeadingIsTheSameIfFixesArriveLate) {
  const std::string yaml = "sensors:\n" + kWheels + gps("sigma_vertical_m: 0.2");
  std::vector<Measurement> log = driven(0.5, 1.2, 0.8, 6.0);
  FusionRobot ideal(yaml);
  ideal.play(log);
  ASSERT_TRUE(ideal.fusion().started());
  for (const double delay : {0.05, 0.5, 1.5}) {  // s; the wheels come every 0.02 s
    std::vector<Measurement> late = log;
    for (Measurement& m : late) {
      if (m.sensor == 1) m.arrival = m.stamp + from_seconds(delay);
    }
    std::ranges::stable_sort(late, {}, &Measurement::arrival);
    FusionRobot robot(yaml);
    robot.play(late);
    ASSERT_TRUE(robot.fusion().started()) << delay;
    EXPECT_TRUE(robot.bytes() == ideal.bytes()) << delay;
    EXPECT_EQ(robot.report(1).before_start, 0U) << delay;
  }
}

TEST(FusionStart, AChordThatOnlyTheWheelsErrorsExplainIsNoHeading) {
  // Nothing is known of the rotation, so the path may have any shape.
  const std::string wheels =
      "  - { name: wheels, plugin: odometry, model: twist, yaw_noise_rad_per_sqrt_s: [20, 0, 0] }\n";
  FusionRobot robot("sensors:\n" + wheels + gps());
  robot.play(driven(0.0, 0.3, 0.0, 6.0));
  EXPECT_FALSE(robot.fusion().started());
}

TEST(FusionStart, WithoutAMeasuredSpeedTheHeadingIsTheChord) {
  const std::string gyro =
      "  - { name: imu, plugin: imu, tilt: false, reports_standstill: false, base_T_sensor: {} }\n";
  FusionRobot robot("sensors:\n" + gyro + gps());
  std::vector<Measurement> log;
  for (int k = 0; k < 200; ++k) {
    ImuSample sample;
    sample.w_sensor.setZero();
    sample.f_sensor = {0.0, 0.0, 9.81};
    log.push_back(reading(0.02 * k, 0, std::make_shared<ImuSample>(sample)));
  }
  for (int k = 0; k < 8; ++k) log.push_back(fix(0.5 * k, 0.0, 0.5 * k));
  robot.play(in_order(log));
  ASSERT_TRUE(robot.fusion().started());
  EXPECT_NEAR(robot.pose().yaw(), 90.0 * kDeg, 5.0 * kDeg);
}

/// A map of a place that was loaded.
class KnownPlace final : public MapModule {
 public:
  std::unique_ptr<ParticleMap> create_map() const override { return std::make_unique<ToyMap>(ToyMap::Fails::never); }
  bool has_prior_map() const override { return true; }
  std::shared_ptr<const Observation> extract(const Measurement&, std::span<const Companion>,
                                             const MotionWindow&) override {
    return nullptr;
  }
  std::unique_ptr<ParticleMap> load_map(InArchive& in) const override { return ToyMap::load(in); }
};

TEST(FusionStart, InALoadedMapTheHeadingHasTheUncertaintyOfTheYamlAlsoIfItGivesNone) {
  for (const std::string yaw : {"", "yaw_deg: 0, "}) {
    MapSlot slot;
    slot.name = "place";
    slot.module = std::make_shared<KnownPlace>();
    slot.inputs = {1};
    FusionRobot robot("initial: { x_m: 0, y_m: 0, " + yaw + "yaw_sigma_deg: 90 }\nsensors:\n" + kWheels +
                          "  - { name: scanner, payload: LaserScan }\n",
                      {}, {slot});
    robot.play({twist(0.0, 0.0)});
    EXPECT_NEAR(robot.pose_P()(2, 2), 90.0 * 90.0 * kDeg * kDeg, 1e-9) << yaw;
  }
}

TEST(FusionStart, FromAFixSubtractsTheLeverArm) {
  FusionRobot robot("initial: { yaw_deg: 90, yaw_sigma_deg: 2 }\nsensors:\n" + kWheels +
                    "  - { name: gps, plugin: dgps, base_p_antenna_m: [2, 0, 1], sigma_m: 0.1, offset_sigma_m: 0 }\n");
  robot.play(in_order({twist(0.0, 0.0), fix(0.05, 10.0, 5.0), twist(0.1, 0.0)}));
  EXPECT_NEAR(robot.pose().p.x(), 10.0, 1e-9);
  EXPECT_NEAR(robot.pose().p.y(), 3.0, 1e-9);
  // The arm points north, so what is not known of the heading moves the base in the east, and both errors are
  // correlated.
  const double yaw_variance = 4.0 * kDeg * kDeg;
  const Eigen::Matrix3d P = robot.seen()[1].belief.P.topLeftCorner<3, 3>();
  EXPECT_NEAR(P(0, 0), 0.01 + 4.0 * yaw_variance, 1e-9);
  EXPECT_NEAR(P(1, 1), 0.01, 1e-9);
  EXPECT_NEAR(P(0, 2), 2.0 * yaw_variance, 1e-9);
}

TEST(FusionStart, TheFixThatGaveTheStartIsNotFusedTwice) {
  FusionRobot robot("initial: { yaw_deg: 0, yaw_sigma_deg: 1 }\nsensors:\n" + kWheels + gps());
  robot.play(in_order({fix(0.0, 10.0, 5.0), twist(0.05, 0.0)}));
  EXPECT_EQ(robot.report(1).fused, 1U);
  EXPECT_EQ(robot.report(1).nis_count, 0U);
  EXPECT_NEAR(robot.pose_P()(0, 0), 0.01, 1e-12);
}

TEST(FusionStart, HeadingComesFromFixesFarEnoughApart) {
  std::vector<Measurement> log;
  drive(log, 0.0, 4.0, 1.0);
  const double yaw = 30.0 * kDeg;
  for (int k = 0; k < 20; ++k) {
    const double t = 0.02 + 0.2 * k;
    log.push_back(fix(t, 5.0 + t * std::cos(yaw), 7.0 + t * std::sin(yaw)));
  }
  FusionRobot robot("sensors:\n" + kWheels + gps());
  robot.play(in_order(log));
  ASSERT_TRUE(robot.fusion().started());
  EXPECT_NEAR(robot.pose().yaw(), yaw, 1e-6);
  EXPECT_NEAR(robot.pose().p.x(), 5.0 + 3.9 * std::cos(yaw), 0.05);
  // 5σ of two fixes, 0.71 m, lie between the first fix and the fifth.
  EXPECT_EQ(robot.report(1).before_start, 0U) << "the start is the first fix, so all later ones are fused";
  EXPECT_EQ(robot.report(1).fused, 20U);
  EXPECT_EQ(robot.report(0).before_start, 1U) << "only the twist before the first fix is lost";
}

TEST(FusionStart, WaitsForTheFirstMotionMeasurement) {
  FusionRobot robot("initial: { yaw_deg: 0 }\nsensors:\n" + kWheels + gps());
  robot.play(in_order({fix(0.0, 1.0, 2.0), fix(1.0, 1.0, 2.0)}));
  EXPECT_FALSE(robot.fusion().started());
  EXPECT_THAT(robot.events(), HasSubstr("no motion sensor has delivered a measurement"));
}

TEST(FusionStart, FixesTooCloseTogetherGiveNoHeading) {
  FusionRobot robot("sensors:\n" + kWheels + gps());
  std::vector<Measurement> log;
  drive(log, 0.0, 5.0, 0.1);
  for (int k = 0; k < 5; ++k) log.push_back(fix(k, 0.1 * k, 0.0));
  robot.play(in_order(log));
  EXPECT_FALSE(robot.fusion().started());
  EXPECT_THAT(robot.events(), HasSubstr("the filter never started: the heading is unknown"));
  EXPECT_THAT(robot.events(),
              HasSubstr("the fixes lie up to 0.4 m apart, and the way by the motion sensors is 0.4 m ("));
  EXPECT_EQ(robot.report(0).before_start, 50U);
  EXPECT_EQ(robot.report(1).before_start, 5U);
}

TEST(FusionStart, AWrongUnitOfTheSpeedShowsInTheReasonForNoHeading) {
  FusionRobot robot("sensors:\n" + kWheels + gps());
  std::vector<Measurement> log;
  drive(log, 0.0, 20.0, 100.0);
  for (int k = 0; k <= 20; ++k) log.push_back(fix(k, 0.05 * k * k, 1.0 * k));
  robot.play(in_order(log));
  EXPECT_FALSE(robot.fusion().started());
  const std::string events = robot.events();
  EXPECT_THAT(events, HasSubstr("° only, 11.5° is needed; the fixes lie up to 28.3 m apart"));
  EXPECT_THAT(events, HasSubstr("m (if these do not fit, a unit is wrong"));
  const std::string way = "the way by the motion sensors is ";
  ASSERT_THAT(events, HasSubstr(way));
  EXPECT_NEAR(std::stod(events.substr(events.find(way) + way.size())), 2000.0, 100.0);
}

TEST(FusionStart, WithoutAMeasuredSpeedTheReasonForNoHeadingIsTheDistanceThatIsNeeded) {
  const std::string gyro =
      "  - { name: imu, plugin: imu, tilt: false, reports_standstill: false, base_T_sensor: {} }\n";
  FusionRobot robot("sensors:\n" + gyro + gps());
  robot.play(in_order({fix(0.0, 0.0, 0.0), fix(1.0, 0.3, 0.0)}));
  EXPECT_FALSE(robot.fusion().started());
  EXPECT_THAT(
      robot.events(),
      HasSubstr("no sensor has measured the speed, and the fixes lie up to 0.3 m apart; 0.7 m are needed (set"));
}

TEST(FusionStart, MeasurementsBeforeTheFirstFixAreCountedAndReported) {
  std::vector<Measurement> log;
  drive(log, 0.0, 2.0, 1.0);
  log.push_back(fix(1.05, 0.0, 0.0));
  FusionRobot robot("initial: { yaw_deg: 0 }\nsensors:\n" + kWheels + gps());
  robot.play(in_order(log));
  EXPECT_EQ(robot.report(0).before_start, 11U);
  EXPECT_EQ(robot.report(0).fused, 9U);
  EXPECT_EQ(robot.seen().size(), 21U);
  EXPECT_EQ(robot.seen()[10].fate, Fate::before_start);
  EXPECT_EQ(robot.seen()[11].fate, Fate::fused);
}

TEST(FusionStart, AnUnusableFixIsNoStart) {
  auto none = std::make_shared<GnssFix>();
  none->p_map_antenna = {50.0, 50.0, 0.0};
  none->type = GnssFix::Type::none;
  FusionRobot robot("initial: { yaw_deg: 0 }\nsensors:\n" + kWheels + gps());
  robot.play(in_order({twist(0.0, 0.0), reading(0.05, 1, none), twist(0.1, 0.0), fix(0.2, 1.0, 2.0), twist(0.2, 0.0)}));
  EXPECT_EQ(robot.pose().p, Eigen::Vector3d(1.0, 2.0, 0.0));
}

TEST(FusionStart, ParticlesDrawTheirStart) {
  FusionRobot robot(kAtOrigin + "filter: { particles: 500, sampling_fraction: 1 }\nsensors:\n" + kWheels + gps());
  robot.play({twist(0.0, 0.0)});
  EXPECT_GT(robot.filter().particles()[0].belief.mean.T_map_base.p.norm(), 0.0);
  // A variance out of 500 draws: 5σ, σ = √(2/500) of it.
  EXPECT_NEAR(robot.pose_P()(0, 0), 0.01, 0.01 * 5.0 * std::sqrt(2.0 / 500.0));
}

TEST(FusionStart, WithoutAMotionSourceIsRefused) {
  try {
    FusionRobot robot(kAtOrigin + "sensors:\n" + gps());
    FAIL() << "nothing was thrown";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), HasSubstr("none of the enabled sensors measures the motion"));
  }
  EXPECT_THROW(FusionRobot(kAtOrigin + "sensors:\n  - { name: wheels, plugin: odometry, model: twist, fuse: none }\n"),
               ConfigError);
}

TEST(FusionStart, SpatialMotionWithoutRollAndPitchIsRefused) {
  EXPECT_THROW(FusionRobot("motion: { kind: spatial }\nsensors:\n" + kWheels), ConfigError);
}

TEST(FusionStart, FrontBeforeTheStartIsAnError) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels);
  EXPECT_THROW(robot.fusion().front(at(1.0)), Error);
}

}  // namespace
}  // namespace waymark
