// SPDX-License-Identifier: Apache-2.0
// needs plugins: dgps, odometry
// `motion.source: maps`: a robot without odometry.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "unit/core/fusion_robot.hpp"
#include "unit/core/toy_map.hpp"

namespace waymark {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;
using namespace test;  // NOLINT(google-build-using-namespace): the robot's parts

constexpr double kSpeed = 2.0;    // [m/s]
constexpr double kYawRate = 0.1;  // [rad/s]
constexpr double kPeriod = 0.1;   // of the scans [s]

Pose truth(double t) {
  const double yaw = kYawRate * t;
  const double radius = kSpeed / kYawRate;
  return Pose::planar(radius * std::sin(yaw), radius * (1.0 - std::cos(yaw)), yaw);
}

/// Detects three known landmarks from the robot's true pose.
class KnownLandmarks final : public MapModule {
 public:
  std::unique_ptr<ParticleMap> create_map() const override { return std::make_unique<ToyMap>(ToyMap::Fails::never); }
  std::shared_ptr<const Observation> extract(const Measurement& trigger, std::span<const Companion>,
                                             const MotionWindow&) override {
    auto sighting = std::make_shared<test::Sighting>();
    sighting->sigma_m = 0.02;
    const Pose T_map_base = truth(to_seconds(trigger.stamp.time_since_epoch()));
    for (const Eigen::Vector2d& p_map : {Eigen::Vector2d(10, 5), Eigen::Vector2d(-8, 7), Eigen::Vector2d(3, -9)})
      sighting->see(T_map_base, p_map, Eigen::Vector2d::Zero());
    return sighting;
  }
  std::unique_ptr<ParticleMap> load_map(InArchive& in) const override { return ToyMap::load(in); }
};

const std::string kByMaps = "motion: { source: maps }\ninitial: { x_m: 0, y_m: 0, yaw_deg: 0 }\nsensors:\n";
const std::string kLidar = "  - { name: lidar, payload: LaserScan }\n";

std::vector<MapSlot> one_map(bool localize = true) {
  return {{"known", "toy", std::make_shared<KnownLandmarks>(), {0}, Duration{}, localize, 1.0}};
}

std::vector<Measurement> scans(int count) {
  std::vector<Measurement> log;
  log.reserve(static_cast<std::size_t>(count));
  for (int k = 0; k < count; ++k) log.push_back(reading(kPeriod * k, 0, std::make_shared<LaserScan>()));
  return in_order(log);
}

TEST(FusionMotionFromMaps, ScansAloneGivePoseAndTwist) {
  FusionRobot robot(kByMaps + kLidar, {}, one_map());
  robot.play(scans(31));
  const double end = 30 * kPeriod;
  EXPECT_NEAR((robot.pose().p - truth(end).p).norm(), 0.0, 0.02);
  EXPECT_NEAR(robot.pose().yaw(), kYawRate * end, 0.005);
  const NavState& mean = robot.filter().mixture().mean;
  EXPECT_NEAR(mean.v_base.x(), kSpeed, 0.05);
  EXPECT_NEAR(mean.w_base.z(), kYawRate, 0.02);
  EXPECT_EQ(robot.report(0).mapped, 31U);
}

TEST(FusionMotionFromMaps, TheFirstMappingMeasurementStartsTheFilter) {
  FusionRobot robot(kByMaps + kLidar + "  - { name: camera, payload: Image }\n", {}, one_map());
  std::vector<Measurement> log = scans(2);
  for (Measurement& scan : log) scan.stamp = scan.arrival = scan.stamp + from_seconds(0.5);
  log.push_back(reading(0.2, 1, std::make_shared<Image>()));
  robot.play(in_order(log));
  EXPECT_EQ(robot.report(1).before_start, 1U);
  EXPECT_EQ(robot.report(0).mapped, 2U);
}

TEST(FusionMotionFromMaps, WithoutAMappingMeasurementItNeverStarts) {
  FusionRobot robot(kByMaps + kLidar + "  - { name: camera, payload: Image }\n", {}, one_map());
  robot.play({reading(0.2, 1, std::make_shared<Image>())});
  EXPECT_FALSE(robot.fusion().started());
  EXPECT_THAT(robot.events(), HasSubstr("the filter never started: no map has received a measurement"));
}

TEST(FusionMotionFromMaps, NeedsAMapThatLocalisesAndNoMotionSensor) {
  const auto refused = [](const std::string& sensors, std::vector<MapSlot> maps, const std::string& words) {
    EXPECT_THAT([&] { FusionRobot(kByMaps + sensors, {}, maps); }, ThrowsMessage<ConfigError>(HasSubstr(words)));
  };
  refused(kLidar, {}, "motion.source: maps needs a map that localises");
  refused(kLidar, one_map(false), "motion.source: maps needs a map that localises");
  refused("  - { name: lidar, payload: LaserScan, enabled: false }\n", one_map(), "motion.source: maps needs a map");
  refused("  - { name: lidar, payload: LaserScan, fuse: none }\n", one_map(), "motion.source: maps needs a map");
  refused(kLidar + kWheels, one_map(), "is for a robot without a motion sensor");
}

}  // namespace
}  // namespace waymark
