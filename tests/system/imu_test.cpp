// SPDX-License-Identifier: Apache-2.0
// needs plugins: diagnostics, imu, odometry, simulator, tum
// A simulated robot with an IMU: its rates make the heading better, in the plane and in space.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "tests/system/outputs.hpp"
#include "waymark/math/so3.hpp"

namespace waymark::system_test {
namespace {

const std::string kRobot = R"(source:
  plugin: simulator
  seed: 1
  duration_s: 60
  speed_mps: 1.0
  course: { waypoints_m: [0, 0, 24, 0, 24, 14, 0, 14], laps: 1 }
  wheels: { sensor: wheels, rate_hz: 40, track_m: 0.5, noise_m_per_sqrt_s: 0.005, scale_error_left: 0.01, scale_error_right: -0.01 }
  imu: { sensor: imu }
initial: { x_m: 0, y_m: 0, position_sigma_m: 0.1, yaw_deg: 0, yaw_sigma_deg: 0.5 }
motion: { kind: planar }
sensors:
  - { name: wheels, plugin: odometry, model: differential, track_m: 0.5, curvature_sigma_per_m: 0.05 }
  - { name: imu, plugin: imu, base_T_sensor: { xyz_m: [0.1, 0, 0.3], yaw_deg: 90 } }
filter: { particles: 1 }
sinks:
  - { plugin: tum }
  - { plugin: diagnostics }
)";

/// Time and heading of each row of a TUM file.
std::vector<std::array<double, 2>> headings(const std::filesystem::path& file) {
  std::vector<std::array<double, 2>> rows;
  for (const std::string& line : lines_of(read_text(file))) {
    if (line.empty() || line.front() == '#') continue;
    std::istringstream in(line);
    std::array<double, 8> v{};
    for (double& x : v) in >> x;
    rows.push_back({v[0], so3::yaw(Eigen::Quaterniond(v[7], v[4], v[5], v[6]))});
  }
  return rows;
}

/// Root mean square of the heading's error [deg] of a run with these overrides.
double heading_error(const std::vector<std::string>& overrides) {
  const TemporaryFolder folder;
  write_text(folder / "robot.yaml", kRobot);
  std::vector<std::string> arguments{"run", (folder / "robot.yaml").string(), "--out", (folder / "out").string()};
  for (const std::string& text : overrides) {
    arguments.emplace_back("--set");
    arguments.push_back(text);
  }
  const Outcome outcome = waymark(arguments);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto estimate = headings(folder / "out" / "trajectory.txt");
  double sum = 0.0;
  double count = 0.0;
  std::size_t i = 0;
  for (const auto& [t, yaw] : headings(folder / "out" / "reference.txt")) {
    while (i + 1 < estimate.size() && estimate[i + 1][0] <= t) ++i;
    sum += std::pow(so3::wrap(estimate[i][1] - yaw), 2);
    count += 1.0;
  }
  EXPECT_GT(count, 100.0);
  return std::sqrt(sum / count) * 180.0 / std::numbers::pi;
}

TEST(ImuOnARobot, ItsRatesMakeTheHeadingBetter) {
  const double without = heading_error({"sensors.imu.enabled=false"});
  EXPECT_GT(without, 10.0) << "the wheels are too good to show anything";
  EXPECT_LT(heading_error({}), 3.0);
  EXPECT_LT(heading_error({"motion.kind=spatial"}), 3.0);
}

TEST(ImuOnARobot, TheHeadingOfTheMagnetometerDoesNotDrift) {
  EXPECT_LT(heading_error({"sensors.imu.heading=true", "source.duration_s=170", "source.course.laps=2"}), 6.0);
}

}  // namespace
}  // namespace waymark::system_test
