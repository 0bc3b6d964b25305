// SPDX-License-Identifier: Apache-2.0
// needs plugins: odometry
// Axes of an odometry that delivers displacements, beside a scanner.
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "tests/unit/apps/host/diagnosis/measurement_feed.hpp"
#include "tests/unit/apps/host/diagnosis/scanned_room.hpp"
#include "waymark/host/diagnosis.hpp"
#include "waymark/interface/payloads.hpp"

namespace waymark::host {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* kYaml = R"({ initial: { x_m: 0, y_m: 0, yaw_deg: 0 },
  sensors: [{ name: wheels, plugin: odometry, model: increment },
            { name: lidar, payload: LaserScan, base_T_sensor: { xyz_m: [0, 0, 0] } }] })";
enum Sensor : std::uint32_t { kWheels, kLidar };

/// How the scanner is mounted, and whether its scans are mirrored.
struct Scanner {
  double yaw_deg = 0.0;
  bool is_mirrored = false;
};

LaserScan scan_of(const Scanner& scanner, const Eigen::Vector2d& p, double yaw) {
  LaserScan scan = scan_from(p.x(), p.y(), yaw + scanner.yaw_deg * M_PI / 180.0, 1.0);
  if (scanner.is_mirrored) std::ranges::reverse(scan.ranges_m);
  return scan;
}

/// Drives stars in a room. `mistake`: the displacement that the odometry measures, for one in the room and a heading.
std::vector<Finding> examine(const std::function<Eigen::Vector2d(Eigen::Vector2d, double)>& mistake,
                             const Scanner& scanner = {}) {
  constexpr double kStep = 0.1;  // [s]
  std::string yaml = kYaml;
  yaml.replace(yaml.find("xyz_m: [0, 0, 0]"), 16, "xyz_m: [0, 0, 0], yaw_deg: " + std::to_string(scanner.yaw_deg));
  const Robot robot = Robot::live(Config::parse(yaml, "robot.yaml"), PluginLoader({WAYMARK_PLUGIN_DIR}));
  Diagnosis diagnosis(robot);
  MeasurementFeed feed(diagnosis);
  std::mt19937 dice(5);
  std::normal_distribution<double> noise(0.0, 0.002);
  Eigen::Vector2d p(-1.0, 0.3);
  double yaw = 0.1;
  for (int k = 0; k < 1800; ++k) {
    const double t = kStep * k;
    feed.pass(kLidar, t, std::make_shared<LaserScan>(scan_of(scanner, p, yaw)));
    const bool turns = k % 50 >= 40;  // 2 m on, then turns in place
    const Eigen::Vector2d d =
        turns ? Eigen::Vector2d(0.0, 0.0) : Eigen::Vector2d(Eigen::Rotation2Dd(yaw) * Eigen::Vector2d(0.05, 0.0));
    const double turn = turns ? 0.4 * M_PI * 2.0 / 10.0 : 0.0;
    PoseIncrement increment;
    increment.interval_s = kStep;
    const Eigen::Vector2d seen = Eigen::Rotation2Dd(-yaw) * mistake(d, yaw);
    increment.x_m = seen.x() + noise(dice);
    increment.y_m = seen.y() + noise(dice);
    increment.yaw_rad = turn + noise(dice);
    feed.pass(kWheels, t, std::make_shared<PoseIncrement>(increment));
    p += d;
    yaw += turn;
  }
  diagnosis.finish();
  return diagnosis.findings();
}

TEST(DirectionDiagnosis, FindsNothingWithoutAMistake) {
  EXPECT_THAT(examine([](const Eigen::Vector2d& d, double) { return d; }), IsEmpty());
}

TEST(DirectionDiagnosis, NamesAHeadingThatCountsFromAnotherAxis) {
  const std::vector<Finding> findings =
      examine([](const Eigen::Vector2d& d, double) { return Eigen::Vector2d(Eigen::Rotation2Dd(-0.5 * M_PI) * d); });
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_THAT(findings.front().sensors, ElementsAre("wheels"));
  EXPECT_THAT(findings.front().seen, HasSubstr("it moves -90 degrees beside its own x axis"));
}

TEST(DirectionDiagnosis, NamesSwappedAxes) {
  const std::vector<Finding> findings =
      examine([](const Eigen::Vector2d& d, double) { return Eigen::Vector2d(d.y(), d.x()); });
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_THAT(findings.front().sensors, ElementsAre("wheels"));
  EXPECT_THAT(findings.front().change, HasSubstr("x and y of wheels"));
}

TEST(DirectionDiagnosis, NamesMirroredScansByTheDirectionOfTheirMotion) {
  const auto right = [](const Eigen::Vector2d& d, double) { return d; };
  EXPECT_THAT(examine(right, {.yaw_deg = 100.0}), IsEmpty());
  const std::vector<Finding> findings = examine(right, {.yaw_deg = 100.0, .is_mirrored = true});
  ASSERT_FALSE(findings.empty());
  for (const Finding& finding : findings) EXPECT_THAT(finding.sensors, ElementsAre("lidar")) << describe(finding);
  EXPECT_THAT(findings.front().change, HasSubstr("mirrored"));
}

}  // namespace
}  // namespace waymark::host
