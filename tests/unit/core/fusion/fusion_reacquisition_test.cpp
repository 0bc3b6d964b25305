// SPDX-License-Identifier: Apache-2.0
// needs plugins: dgps, odometry
// After many rejections in a row the covariance of what the sensor observes is inflated.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "unit/core/fusion_robot.hpp"
#include "unit/core/toy_map.hpp"

namespace waymark {
namespace {

using ::testing::HasSubstr;
using namespace test;  // NOLINT(google-build-using-namespace): the robot's parts

std::vector<Measurement> jump_at_20() {
  std::vector<Measurement> log;
  drive(log, 0.0, 40.0, 1.0);
  for (int k = 0; k < 40; ++k) log.push_back(fix(k, k, k < 20 ? 0.0 : 100.0));
  return in_order(log);
}

TEST(FusionReacquisition, FollowsManyRejectionsInARow) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels + gps("jump_sigmas: 0, max_consecutive_rejections: 5"));
  robot.play(jump_at_20());
  EXPECT_THAT(robot.events(), HasSubstr("gps: 5 measurements in a row rejected"));
  EXPECT_EQ(robot.report(1).gated, 5U);
  EXPECT_NEAR(robot.pose().p.y(), 100.0, 1.0);
  EXPECT_NEAR(robot.pose().p.x(), 40.0, 1.0);
}

TEST(FusionReacquisition, IsOffWithZero) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels + gps("jump_sigmas: 0, max_consecutive_rejections: 0"));
  robot.play(jump_at_20());
  EXPECT_EQ(robot.report(1).gated, 20U);
  EXPECT_EQ(robot.events(), "");
  EXPECT_NEAR(robot.pose().p.y(), 0.0, 2.0);
}

/// Gives a position that is wrong for good, and a twist that fits.
class HalfWrong final : public Sensor {
 public:
  SensorTraits traits() const override { return {.is_absolute = true}; }
  void process(const Measurement&, const Prediction&, UpdateList& out) override {
    out.emplace<PositionModel>(Eigen::Vector2d(500.0, 0.0), 0.1);
    out.emplace<TwistModel>(Eigen::Vector3d(1.0, 0.0, 0.0), Eigen::Vector3d(1.0, 1.0, 1.0));
  }
  std::unique_ptr<Sensor> clone() const override { return std::make_unique<HalfWrong>(*this); }
};

TEST(FusionReacquisition, AnUpdateThatFitsDoesNotHideOneThatIsAlwaysRejected) {
  FusionRobot robot(
      kAtOrigin + "sensors:\n" + kWheels + "  - { name: half, plugin: half, max_consecutive_rejections: 5 }\n",
      {{"half", std::make_shared<HalfWrong>()}});
  std::vector<Measurement> log;
  drive(log, 0.0, 10.0, 1.0);
  for (int k = 0; k < 10; ++k) log.push_back(fix(k + 0.05, 0.0, 0.0));
  robot.play(in_order(log));
  EXPECT_THAT(robot.events(), HasSubstr("half: 5 measurements in a row rejected"));
  EXPECT_NEAR(robot.pose().p.x(), 500.0, 10.0);
}

/// Takes fixes as they are and states that each follows the ones before.
class Following final : public Sensor {
 public:
  static constexpr double kSigma = 0.1;
  SensorTraits traits() const override { return {.is_absolute = true}; }
  void process(const Measurement& m, const Prediction&, UpdateList& out) override {
    out.emplace<PositionModel>(m.as<GnssFix>().p_map_antenna.head<2>(), kSigma);
    out.report_continuous();
  }
  std::unique_ptr<Sensor> clone() const override { return std::make_unique<Following>(*this); }
};

/// Worst state of that sensor in 60 fixes, of which these are beside the way by `miss` σ.
SensorHealth::State worst_with(const std::vector<int>& beside, double miss) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels + "  - { name: following, plugin: following }\n",
                    {{"following", std::make_shared<Following>()}});
  std::vector<Measurement> log;
  drive(log, 0.0, 60.0, 1.0);
  for (int k = 0; k < 60; ++k) {
    const bool is_beside = std::ranges::find(beside, k) != beside.end();
    log.push_back(fix(k, k, is_beside ? miss * Following::kSigma : 0.0));
  }
  auto worst = SensorHealth::State::ok;
  for (const Measurement& m : in_order(log)) {
    robot.play({m});
    worst = std::max(worst, robot.fusion().health().sensors[1].state);
  }
  return worst;
}

// One in a thousand is beyond the gate by chance: that is no fault of the motion source.
TEST(FusionReacquisition, OneFixBeyondTheGateIsNoFault) {
  EXPECT_EQ(worst_with({20}, 7.0), SensorHealth::State::ok);
  EXPECT_EQ(worst_with({20, 50}, 7.0), SensorHealth::State::ok);
  EXPECT_EQ(worst_with({20, 23}, 7.0), SensorHealth::State::degraded);
  EXPECT_EQ(worst_with({20}, 9.0), SensorHealth::State::degraded);
}

/// One row whose residual is always `miss`, in the unit of `quantity`.
class MissUpdate final : public Update {
 public:
  MissUpdate(Quantity quantity, double miss) : quantity_(quantity), miss_(miss) {}
  Quantity observes() const override { return quantity_; }
  void linearize(const StateView&, Linearization& out) const override {
    out.reset(1, 0);
    out.residual(0) = miss_;
    out.R(0, 0) = 0.01 * 0.01;
    switch (quantity_) {
      case Quantity::attitude:
        out.attitude()(0, 2) = 1.0;
        break;
      case Quantity::velocity:
        out.velocity()(0, 0) = 1.0;
        break;
      case Quantity::height:
        out.position()(0, 2) = 1.0;
        break;
      case Quantity::position:
        out.position()(0, 0) = 1.0;
        break;
      case Quantity::other:  // a position in centimetres
        out.R(0, 0) = 1.0;
        out.position()(0, 0) = 100.0;
        break;
    }
  }

 private:
  Quantity quantity_;
  double miss_;
};

class MissSensor final : public Sensor {
 public:
  MissSensor(Quantity quantity, double miss, bool is_absolute = true)
      : quantity_(quantity), miss_(miss), is_absolute_(is_absolute) {}
  SensorTraits traits() const override { return {.is_absolute = is_absolute_, .observes_roll_and_pitch = true}; }
  void process(const Measurement&, const Prediction&, UpdateList& out) override {
    out.emplace<MissUpdate>(quantity_, miss_);
  }
  std::unique_ptr<Sensor> clone() const override { return std::make_unique<MissSensor>(*this); }

 private:
  Quantity quantity_;
  double miss_;
  bool is_absolute_;
};

/// A robot that stood at the origin and drove east for 2 s; then the sensor's fifth rejection in a row.
class Reacquired {
 public:
  explicit Reacquired(MissSensor sensor, const std::string& more = "")
      : robot_(kAtOrigin + more + "sensors:\n" + kWheels +
                   "  - { name: miss, plugin: miss, max_consecutive_rejections: 5 }\n",
               {{"miss", std::make_shared<MissSensor>(sensor)}}) {
    std::vector<Measurement> log;
    drive(log, 0.0, 2.0, 1.0);
    for (int k = 0; k < 5; ++k) log.push_back(reading(1.51 + 0.1 * k, 1, std::make_shared<BodyTwist>()));
    robot_.play(in_order(log));
    EXPECT_THAT(robot_.events(), HasSubstr("miss: 5 measurements in a row rejected"));
  }

  const NavState& mean() { return robot_.seen().back().belief.mean; }
  /// σ² of x, y [m²] and yaw [rad²].
  Eigen::Vector3d variances() { return robot_.pose_P().diagonal(); }
  /// σ² of the velocity forwards [m²/s²].
  double speed_variance() {
    const int i = robot_.fusion().layout().active(6);
    return robot_.seen().back().belief.P(i, i);
  }

 private:
  FusionRobot robot_;
};

TEST(FusionReacquisition, TakesPositionsInMetres) {
  Reacquired robot({Quantity::position, 30.0});
  EXPECT_NEAR(robot.mean().T_map_base.p.x(), 32.0, 1.0);
  EXPECT_NEAR(robot.variances().y(), 30.0 * 30.0, 10.0) << "one row may be a distance in any direction";
}

TEST(FusionReacquisition, DoesNotTakeRadiansForMetres) {
  Reacquired robot({Quantity::attitude, 3.0});
  EXPECT_NEAR(robot.mean().T_map_base.yaw(), 3.0, 0.1) << "it follows a heading that was off by more than 10°";
  EXPECT_LT(robot.variances().y(), 1.0);
}

TEST(FusionReacquisition, DoesNotTakeVelocitiesForMetres) {
  Reacquired robot({Quantity::velocity, 30.0});
  EXPECT_LT(robot.variances().x(), 1.0);
  EXPECT_GT(robot.variances().z(), 0.17 * 0.17) << "a velocity over ground depends on the heading";
}

TEST(FusionReacquisition, InflatesTheHeightAlone) {
  Reacquired robot({Quantity::height, 300.0}, "motion: { kind: spatial }\n");
  EXPECT_GT(robot.mean().T_map_base.p.z(), 290.0);
  EXPECT_LT(robot.variances().y(), 1.0);
}

TEST(FusionReacquisition, OfAnUnknownUnitScalesTheCovariance) {
  Reacquired robot({Quantity::other, 3000.0});
  EXPECT_NEAR(robot.mean().T_map_base.p.x(), 32.0, 1.0);
  EXPECT_LT(std::sqrt(robot.variances().y()), 100.0) << "centimetres are not metres";
}

TEST(FusionReacquisition, OfARelativeAttitudeKeepsTheTwist) {
  Reacquired robot({Quantity::attitude, 3.0, false});
  EXPECT_LT(robot.speed_variance(), 1.0);
}

}  // namespace
}  // namespace waymark
