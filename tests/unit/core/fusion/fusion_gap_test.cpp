// SPDX-License-Identifier: Apache-2.0
// needs plugins: compass, dgps, odometry
// The pose is lost: after a long gap, after a clock that was set, and with a covariance that is none.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <sstream>

#include "unit/core/fusion_robot.hpp"
#include "unit/core/toy_map.hpp"

namespace waymark {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using namespace test;  // NOLINT(google-build-using-namespace): the robot's parts

constexpr double kDays = 86400.0;
constexpr double kYears = 365.25 * kDays;

/// A drive of 30 s from (east, north) at 1 m/s, with fixes of 0.1 m at 5 Hz.
void leg(std::vector<Measurement>& log, double from, double east, double north, double yaw) {
  Random random = stream(17);
  drive(log, from, from + 30.0, 1.0);
  for (int k = 0; k < 150; ++k) {
    const double way = 0.2 * k;
    log.push_back(fix(from + way, east + way * std::cos(yaw) + 0.1 * random.normal(),
                      north + way * std::sin(yaw) + 0.1 * random.normal()));
  }
}

/// East for 30 s; `gap` seconds later, from (40, 500), north for 30 s.
std::vector<Measurement> with_gap(double gap) {
  std::vector<Measurement> log;
  leg(log, 0.0, 0.0, 0.0, 0.0);
  leg(log, 30.0 + gap, 40.0, 500.0, 0.5 * std::numbers::pi);
  return in_order(log);
}

std::string robot(const std::string& more = "", const std::string& of_gps = "") {
  return kAtOrigin + more + "sensors:\n" + kWheels + gps(of_gps);
}

void expect_at_the_end(const FusionRobot& robot) {
  EXPECT_NEAR(robot.pose().p.x(), 40.0, 0.5);
  EXPECT_NEAR(robot.pose().p.y(), 530.0, 0.5);
  EXPECT_NEAR(robot.pose().yaw(), 0.5 * std::numbers::pi, 0.1);
  EXPECT_LT(robot.pose_P().diagonal().maxCoeff(), 0.1);
  EXPECT_GT(robot.pose_P().diagonal().minCoeff(), 0.0);
}

class FusionGap : public ::testing::TestWithParam<double> {};

TEST_P(FusionGap, ALongGapIsANewStart) {
  FusionRobot robot(::waymark::robot());
  robot.play(with_gap(GetParam()));
  expect_at_the_end(robot);
  EXPECT_EQ(robot.report(1).unusable, 0U);
  EXPECT_EQ(robot.report(1).gated, 0U);
  EXPECT_THAT(robot.events(), HasSubstr("the pose is lost; position, heading and twist are found anew"));
  EXPECT_THAT(robot.events(), HasSubstr("position and heading were found anew"));
}

INSTANTIATE_TEST_SUITE_P(Gaps, FusionGap, ::testing::Values(61.0, 1800.0, 5.0 * 3600.0, 8.0 * kDays, 50.0 * kYears));

TEST(FusionGap, AShortGapIsPredicted) {
  std::vector<Measurement> log;
  leg(log, 0.0, 0.0, 0.0, 0.0);
  leg(log, 59.0, 59.0, 0.0, 0.0);
  FusionRobot robot(::waymark::robot());
  robot.play(in_order(log));
  EXPECT_THAT(robot.events(), Not(HasSubstr("lost")));
  EXPECT_EQ(robot.report(0).before_start, 0U);
}

TEST(FusionGap, OneStampAheadIsNoGap) {
  std::vector<Measurement> log = with_gap(0.1);
  for (const double ahead : {100.0, 1000.0}) {
    Measurement stray = fix(20.0 + ahead, 20.0, 0.0);
    stray.sequence = 5000 + static_cast<std::uint64_t>(ahead);
    log.insert(log.begin() + 250, stray);
  }
  FusionRobot robot(::waymark::robot());
  robot.play(log);
  EXPECT_EQ(robot.report(1).mistimed, 2U);
  EXPECT_EQ(robot.report(1).late + robot.report(0).late, 0U);
  EXPECT_THAT(robot.events(), Not(HasSubstr("lost")));
}

TEST(FusionGap, TheThresholdIsAKey) {
  FusionRobot robot(::waymark::robot("clock: { max_gap_s: 5 }\n"));
  robot.play(with_gap(6.0));
  expect_at_the_end(robot);
  EXPECT_THAT(robot.events(), HasSubstr("no measurement for 6."));
}

/// A covariance that was predicted through years is none any more: it is found anew, too, not used.
TEST(FusionGap, AnAwfulCovarianceIsANewStart) {
  for (const double gap : {3.0 * kDays, 8.0 * kDays, 50.0 * kYears}) {
    FusionRobot robot(::waymark::robot("clock: { max_gap_s: 1.0e+12, max_jump_s: 1.0e+12 }\n"));
    robot.play(with_gap(gap));
    expect_at_the_end(robot);
    EXPECT_THAT(robot.events(), HasSubstr("the covariance is not positive definite any more: the pose is lost")) << gap;
    EXPECT_EQ(robot.report(0).mistimed + robot.report(1).mistimed, 0U) << "never, not always";
  }
}

TEST(FusionGap, IsReportedByTheHealth) {
  FusionRobot robot(::waymark::robot());
  std::vector<std::string> reasons;
  for (const Measurement& m : with_gap(100.0)) {
    robot.fusion().add(m);
    const Health& health = robot.fusion().health();
    if (health.state == Health::State::lost && (reasons.empty() || reasons.back() != health.reason))
      reasons.push_back(health.reason);
  }
  EXPECT_EQ(reasons,
            (std::vector<std::string>{"position and heading are found anew", "position and heading began anew"}));
  EXPECT_EQ(robot.fusion().health().state, Health::State::ok) << robot.fusion().health().reason;
}

TEST(FusionGap, TheSensorsOwnStatesStay) {
  const std::string wheels = "  - { name: wheels, plugin: odometry, model: twist, speed_scale_sigma: 0.1 }\n";
  const auto scale_after = [&](double gap) {
    std::vector<Measurement> log = with_gap(gap);
    for (Measurement& m : log) {
      if (m.sensor == 0) m.payload = twist(0.0, 1.05).payload;  // 5 % too fast
    }
    FusionRobot robot(kAtOrigin + "sensors:\n" + wheels + gps());
    double before = 0.0;
    double at_start = 0.0;
    for (const Measurement& m : log) {
      robot.fusion().add(m);
      if (!robot.seen().empty() && robot.seen().back().belief.mean.block.size() > 0) {
        (m.stamp < at(30.0) ? before : at_start) = robot.seen().back().belief.mean.block[0];
        if (m.stamp > at(30.0 + gap)) break;
      }
    }
    return std::pair(before, at_start);
  };
  const auto [before, after] = scale_after(600.0);
  EXPECT_GT(std::abs(before), 0.02);
  EXPECT_NEAR(after, before, 0.01);
}

TEST(FusionGap, WithoutAnAbsoluteSensorItGoesOnFromTheLastPose) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels);
  std::vector<Measurement> log;
  drive(log, 0.0, 10.0, 1.0);
  drive(log, 1000.0, 1010.0, 1.0);
  robot.play(in_order(log));
  EXPECT_THAT(robot.events(), HasSubstr("the filter goes on from the last one, with a wide covariance"));
  EXPECT_GT(robot.pose_P()(0, 0), 100.0);
  EXPECT_NEAR(robot.pose().p.x(), 19.4, 0.1) << "four measurements after the gap are rejected";
  EXPECT_EQ(robot.fusion().health().state, Health::State::lost);
}

TEST(FusionGap, ACompassAloneFindsTheHeading) {
  FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels +
                    "  - { name: compass, plugin: compass, base_T_sensor: {}, declination_deg: 0, sigma_deg: 1 }\n");
  std::vector<Measurement> log;
  const auto heading = [&](double from, double clockwise_from_north) {
    drive(log, from, from + 200.0, 1.0);
    for (int k = 0; k < 200; ++k) {
      auto payload = std::make_shared<CompassHeading>();
      payload->heading_rad = clockwise_from_north;
      log.push_back(reading(from + k, 1, payload));
    }
  };
  heading(0.0, 0.5 * std::numbers::pi);
  heading(1000.0, -0.5 * std::numbers::pi);
  robot.play(in_order(log));
  EXPECT_NEAR(std::abs(robot.pose().yaw()), std::numbers::pi, 0.05);
  EXPECT_THAT(robot.events(), HasSubstr("goes on from the last one"));
}

TEST(FusionGap, ARobotThatIsNotFoundAgainIsAFailure) {
  std::vector<Measurement> log;
  leg(log, 0.0, 0.0, 0.0, 0.0);
  for (int k = 0; k < 100; ++k) log.push_back(fix(500.0 + k, 3.0, 4.0));  // stands, wheels dead
  FusionRobot robot(::waymark::robot());
  robot.play(in_order(log));
  const RunReport report = robot.fusion().report();
  ASSERT_FALSE(report.events.empty());
  EXPECT_TRUE(report.events.back().is_failure);
  EXPECT_THAT(report.events.back().text, HasSubstr("the pose was lost and not found again: the heading is unknown"));
  EXPECT_EQ(robot.fusion().health().state, Health::State::lost);
  EXPECT_EQ(report.sensors[1].before_start, 96U);
  EXPECT_TRUE(robot.fusion().started());
}

TEST(FusionGap, IncrementsAreKnownHoweverLongTheyAre) {
  FusionRobot robot(
      "initial: { x_m: 0, y_m: 0, yaw_deg: 0 }\nsensors:\n"
      "  - { name: wheels, plugin: odometry, model: increment }\n");
  std::vector<Measurement> log;
  for (const auto& [stamp, interval] : {std::pair(0.0, 1.0), {1.0, 1.0}, {2.0, 300.0}, {302.0, 1.0}, {303.0, 1.0}}) {
    auto step = std::make_shared<PoseIncrement>();
    step->interval_s = interval;
    step->x_m = 1.0;
    log.push_back(reading(stamp, 0, step));
  }
  robot.play(in_order(log));
  EXPECT_THAT(robot.events(), Not(HasSubstr("lost")));
  EXPECT_NEAR(robot.pose().p.x(), 3.0, 0.1) << "up to the last stamp";
}

/// Gives positions without a number in them, or with a covariance that is none.
class Unusable final : public Sensor {
 public:
  explicit Unusable(double z, double variance) : z_(z), variance_(variance) {}
  class Model final : public Update {
   public:
    Model(double z, double variance) : z_(z), variance_(variance) {}
    void linearize(const StateView&, Linearization& out) const override {
      out.reset(2, 0);
      out.residual.setConstant(z_);
      out.R = variance_ * Eigen::Matrix2d::Identity();
      out.position().leftCols<2>().setIdentity();
    }

   private:
    double z_;
    double variance_;
  };
  SensorTraits traits() const override { return {.is_absolute = true}; }
  void process(const Measurement&, const Prediction&, UpdateList& out) override { out.emplace<Model>(z_, variance_); }
  std::unique_ptr<Sensor> clone() const override { return std::make_unique<Unusable>(*this); }

 private:
  double z_;
  double variance_;
};

TEST(FusionGap, AnUpdateThatIsUnusableIsItsSensorsFaultNotThePoses) {
  for (const auto& [z, variance] : {std::pair(std::nan(""), 1.0), {0.0, -100.0}, {0.0, HUGE_VAL}}) {
    FusionRobot robot(kAtOrigin + "sensors:\n" + kWheels + "  - { name: toy, plugin: toy }\n",
                      {{"toy", std::make_shared<Unusable>(z, variance)}});
    std::vector<Measurement> log;
    drive(log, 0.0, 30.0, 1.0);
    for (int k = 0; k < 30; ++k) log.push_back(reading(k, 1, std::make_shared<BodyTwist>()));
    robot.play(in_order(log));
    EXPECT_EQ(robot.report(1).unusable, 30U);
    EXPECT_THAT(robot.events(), HasSubstr("toy: the innovation or its covariance is not finite"));
    EXPECT_THAT(robot.events(), Not(HasSubstr("lost")));
    EXPECT_EQ(robot.fusion().health().sensors[1].state, SensorHealth::State::faulty);
    EXPECT_NEAR(robot.pose().p.x(), 29.9, 0.2);
  }
}

/// Detects one landmark of a known map at every scan.
class OnePlace final : public MapModule {
 public:
  std::unique_ptr<ParticleMap> create_map() const override { return std::make_unique<ToyMap>(ToyMap::Fails::never); }
  std::shared_ptr<const Observation> extract(const Measurement&, std::span<const Companion>,
                                             const MotionWindow&) override {
    return std::make_shared<test::Sighting>();
  }
  std::unique_ptr<ParticleMap> load_map(InArchive& in) const override { return ToyMap::load(in); }
};

TEST(FusionGap, MapsStay) {
  for (const std::string georeference : {"true", "false"}) {
    MapSlot slot;
    slot.name = "place";
    slot.module = std::make_shared<OnePlace>();
    slot.inputs = {2};
    FusionRobot robot(kAtOrigin + "georeference: { enabled: " + georeference +
                          " }\nfilter: { particles: 5 }\nsensors:\n" + kWheels + gps() +
                          "  - { name: scanner, payload: LaserScan }\n",
                      {}, {slot});
    std::vector<Measurement> log = with_gap(300.0);
    for (int k = 0; k < 30; ++k) {
      log.push_back(reading(k, 2, std::make_shared<LaserScan>()));
      log.push_back(reading(330.0 + k, 2, std::make_shared<LaserScan>()));
    }
    robot.play(in_order(log));
    const auto& map = dynamic_cast<const ToyMap&>(*robot.filter().particles().front().maps.front());
    EXPECT_GT(map.written().size(), 55U);
    EXPECT_NEAR(robot.pose().p.y(), 530.0, 2.0) << georeference;
    EXPECT_NEAR(robot.pose().p.x(), 40.0, 2.0) << georeference;
  }
}

std::string checkpoint(FusionRobot& robot) {
  std::ostringstream stream;
  OutArchive out(stream);
  robot.fusion().save(out);
  return stream.str();
}

TEST(FusionGap, ACheckpointInTheSearchContinuesWithTheSameBytes) {
  const std::vector<Measurement> log = with_gap(1000.0);
  FusionRobot whole(::waymark::robot());
  whole.play(log);
  for (std::size_t split = 440; split < 480; split += 3) {
    FusionRobot first(::waymark::robot());
    for (std::size_t i = 0; i < split; ++i) first.fusion().add(log[i]);
    FusionRobot second(::waymark::robot());
    std::istringstream stream(checkpoint(first));
    InArchive in(stream);
    std::size_t next = 0;
    second.fusion().resume(in, [&]() -> std::optional<Measurement> { return log[next++]; });
    for (std::size_t i = split; i < log.size(); ++i) second.fusion().add(log[i]);
    second.fusion().finish();
    EXPECT_TRUE(second.bytes() == whole.bytes()) << split;
    EXPECT_EQ(second.events(), whole.events()) << split;
  }
}

/// That steps measure the motion in a gap must be known before the first step after the checkpoint arrives.
TEST(FusionGap, ARunningRobotThatIsResumedKnowsThatItsStepsAreMeasured) {
  const std::string yaml = kAtOrigin + "sensors:\n  - { name: wheels, plugin: odometry, model: increment }\n" + gps();
  const auto step = [](double stamp, double interval) {
    auto payload = std::make_shared<PoseIncrement>();
    payload->interval_s = interval;
    payload->x_m = interval;
    return reading(stamp, 0, payload);
  };
  std::vector<Measurement> log;
  for (int k = 0; k < 20; ++k) {
    log.push_back(step(k, 1.0));
    log.push_back(fix(k + 0.5, k + 0.5, 0.0));
  }
  log.push_back(step(20.0, 300.0));
  const std::size_t split = log.size();
  log.push_back(fix(319.0, 319.0, 0.0));
  log.push_back(step(320.0, 1.0));
  log = in_order(log);
  FusionRobot first(yaml);
  for (std::size_t i = 0; i < split; ++i) first.fusion().add(log[i]);
  std::stringstream stream;
  OutArchive out(stream);
  first.fusion().save_with_measurements(out);
  FusionRobot second(yaml);
  InArchive in(stream);
  second.fusion().resume_with_measurements(in);
  for (FusionRobot* robot : {&first, &second}) {
    for (std::size_t i = split; i < log.size(); ++i) robot->fusion().add(log[i]);
    robot->fusion().finish();
    EXPECT_EQ(robot->report(1).mistimed, 0U);
  }
  EXPECT_EQ(second.events(), first.events());
}

TEST(FusionGap, TheSmootherCarriesNothingAcross) {
  FusionRobot robot(::waymark::robot("filter: { smooth: true }\n"));
  robot.play(with_gap(1000.0));
  for (const SmoothedPose& pose : robot.fusion().report().smoothed) {
    const double t = to_seconds(pose.stamp.time_since_epoch());
    const Eigen::Vector2d truth = t < 40.0 ? Eigen::Vector2d(t, 0.0) : Eigen::Vector2d(40.0, 500.0 + t - 1030.0);
    EXPECT_LT((pose.T_map_base.p.head<2>() - truth).norm(), 0.5) << t;
  }
}

}  // namespace
}  // namespace waymark
