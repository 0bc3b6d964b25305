// SPDX-License-Identifier: Apache-2.0
// needs plugins: odometry
// A map of all six of the pose begins when roll and pitch are known, where a sensor observes them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <sstream>

#include "unit/core/fusion_robot.hpp"
#include "unit/core/toy_map.hpp"

namespace waymark {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using namespace test;  // NOLINT(google-build-using-namespace): the robot's parts

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr double kPeriod = 0.1;  // of all sensors [s]

/// That the robot is level.
class LevelUpdate final : public Update {
 public:
  Quantity observes() const override { return Quantity::attitude; }
  void linearize(const StateView& state, Linearization& out) const override {
    const Eigen::Vector3d up = state.nav.T_map_base.q * Eigen::Vector3d::UnitZ();
    out.reset(2, 0);
    out.residual << up.y(), -up.x();
    out.R.diagonal().setConstant(1e-4);
    out.attitude() << 1.0, 0.0, 0.0, 0.0, 1.0, 0.0;
  }
};

/// Observes roll and pitch from a time on, as an IMU that averages first.
class LevelSensor final : public Sensor {
 public:
  explicit LevelSensor(double from) : from_(from) {}
  SensorTraits traits() const override { return {.observes_roll_and_pitch = true}; }
  void process(const Measurement& m, const Prediction&, UpdateList& out) override {
    if (to_seconds(m.stamp.time_since_epoch()) >= from_) out.emplace<LevelUpdate>();
  }
  std::unique_ptr<Sensor> clone() const override { return std::make_unique<LevelSensor>(*this); }

 private:
  double from_;
};

class SpatialModule final : public MapModule {
 public:
  explicit SpatialModule(bool is_loaded) : is_loaded_(is_loaded) {}
  bool is_spatial() const override { return true; }
  bool has_prior_map() const override { return is_loaded_; }
  std::unique_ptr<ParticleMap> create_map() const override { return std::make_unique<ToyMap>(ToyMap::Fails::never); }
  std::shared_ptr<const Observation> extract(const Measurement&, std::span<const Companion>,
                                             const MotionWindow&) override {
    return std::make_shared<test::Sighting>();
  }
  std::unique_ptr<ParticleMap> load_map(InArchive& in) const override { return ToyMap::load(in); }

 private:
  bool is_loaded_;
};

struct Robot {
  double level_from = 1.0;
  std::string level = "plugin: level";
  bool is_loaded = false;
};

/// Sensors: 0 wheels, 1 lidar, 2 level.
FusionRobot make(const Robot& c) {
  const std::vector<MapSlot> maps{
      {"hall", "toy", std::make_shared<SpatialModule>(c.is_loaded), {1}, Duration{}, true, 1.0}};
  return FusionRobot(kAtOrigin + "motion: { kind: spatial }\nfilter: { particles: 3 }\nsensors:\n" + kWheels +
                         "  - { name: lidar, payload: LaserScan }\n  - { name: level, payload: BodyTwist, " + c.level +
                         " }\n",
                     {{"level", std::make_shared<LevelSensor>(c.level_from)}}, maps);
}

std::vector<Measurement> log_of(double seconds) {
  std::vector<Measurement> log;
  drive(log, 0.0, seconds, 0.0, 0.0, 1.0 / kPeriod);
  const int count = static_cast<int>(seconds / kPeriod);
  for (int k = 0; k < count; ++k) {
    log.push_back(reading(kPeriod * k + 0.01, 1, std::make_shared<LaserScan>()));
    log.push_back(reading(kPeriod * k + 0.02, 2, std::make_shared<BodyTwist>()));
  }
  return in_order(log);
}

TEST(FusionLevel, TheFirstScanWaitsUntilRollAndPitchAreKnown) {
  FusionRobot robot = make({});
  robot.play(log_of(3.0));
  EXPECT_EQ(robot.report(1).skipped, 11U) << "one second, and the scan just before the first level";
  EXPECT_EQ(robot.report(1).mapped, 19U);
  EXPECT_THAT(robot.events(), Not(HasSubstr("askew")));
}

TEST(FusionLevel, AllParticlesBeginTheirMapsAtTheSamePlace) {
  FusionRobot robot = make({});
  robot.play(log_of(3.0));
  const auto first_x = [&](std::size_t particle) {
    return static_cast<const ToyMap&>(*robot.filter().particles()[particle].maps[0]).written().front();
  };
  for (const std::size_t particle : {1U, 2U}) EXPECT_EQ(first_x(particle), first_x(0));
}

TEST(FusionLevel, ASensorThatNeverFindsThemIsNotAwaitedForEver) {
  FusionRobot robot = make({.level_from = kNever});
  robot.play(log_of(12.0));
  EXPECT_EQ(robot.report(1).skipped, 100U);
  EXPECT_EQ(robot.report(1).mapped, 20U);
  EXPECT_THAT(robot.events(), HasSubstr("map hall: begun with roll and pitch known to "));
}

TEST(FusionLevel, NothingIsAwaitedThatNothingWillSay) {
  for (const Robot& c : {Robot{.level = "plugin: level, enabled: false"}, Robot{.level = "plugin: level, fuse: none"},
                         Robot{.level_from = kNever, .is_loaded = true}}) {
    FusionRobot robot = make(c);
    robot.play(log_of(1.0));
    EXPECT_EQ(robot.report(1).skipped, 0U) << c.level;
    EXPECT_EQ(robot.report(1).mapped, 10U) << c.level;
  }
}

TEST(FusionLevel, ACheckpointKnowsHowLongTheMapHasWaited) {
  const std::vector<Measurement> log = log_of(12.0);
  FusionRobot whole = make({.level_from = kNever});
  whole.play(log);
  FusionRobot first = make({.level_from = kNever});
  std::size_t next = 0;
  while (next < log.size() / 2) first.fusion().add(log[next++]);
  std::stringstream stream;
  OutArchive out(stream);
  first.fusion().save(out);

  FusionRobot second = make({.level_from = kNever});
  InArchive in(stream);
  std::size_t again = 0;
  second.fusion().resume(in, [&] { return std::optional(log[again++]); });
  while (next < log.size()) second.fusion().add(log[next++]);
  second.fusion().finish();
  EXPECT_TRUE(second.bytes() == whole.bytes());
  EXPECT_EQ(second.report(1).mapped, 20U);
}

}  // namespace
}  // namespace waymark
