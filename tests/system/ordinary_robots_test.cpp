// SPDX-License-Identifier: Apache-2.0
// needs plugins: csv, dgps, diagnostics, odometry, tum
// README's "log of your own, in ten lines": wheels and GPS, and nothing given but geometry. The robots have ordinary
// errors, and drive curves, in reverse, and on straight legs. tests/results/plans/ordinary_robots.yaml has more of
// them.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/system/command.hpp"
#include "waymark/host/session.hpp"
#include "waymark/math/random.hpp"

namespace waymark::system_test {
namespace {

constexpr double kStep = 0.02;
constexpr double kRadPerDeg = std::numbers::pi / 180.0;

/// What is wrong with a robot that the YAML does not give.
struct Ordinary {
  std::string name;
  std::uint32_t seed;
  double left_scale, right_scale;  ///< of the wheels: measured by true
  double track_scale;              ///< of the track: true by given
  double white_m, slow_m, tau_s;   ///< errors of the receiver
  std::string receiver;            ///< of the YAML; empty: nothing is given
  double first_speed_mps;          ///< negative: it begins in reverse
  double turn_radius_m;            ///< 0: it turns in place between straight legs
  double slip_at_s;                ///< for 2 s its right wheel turns 40 % too fast; negative: never
};

void PrintTo(const Ordinary& robot, std::ostream* out) { *out << robot.name; }

struct Truth {
  double t, x, y, yaw, v, w;
};

/// Legs of 15 m and right angles, alternately to both sides; after a rest of 2 s.
std::vector<Truth> drive(const Ordinary& robot) {
  std::vector<Truth> truth;
  Truth now{0.0, 0.0, 0.0, 0.7, 0.0, 0.0};
  const auto go = [&](double seconds, double to_v, double to_w) {
    for (const double until = now.t + seconds; now.t < until; now.t = kStep * static_cast<double>(truth.size())) {
      truth.push_back(now);
      now.v += std::clamp(to_v - now.v, -kStep, kStep);
      now.w += std::clamp(to_w - now.w, -2.0 * kStep, 2.0 * kStep);
      now.yaw += 0.5 * now.w * kStep;
      now.x += now.v * kStep * std::cos(now.yaw);
      now.y += now.v * kStep * std::sin(now.yaw);
      now.yaw += 0.5 * now.w * kStep;
    }
  };
  go(2.0, 0.0, 0.0);
  double v = robot.first_speed_mps;
  for (int leg = 0; now.t < 240.0; ++leg) {
    const double side = leg % 4 < 2 ? 1.0 : -1.0;
    go(15.0 / std::abs(v), v, 0.0);
    if (robot.turn_radius_m > 0.0) {
      go(0.5 * std::numbers::pi * robot.turn_radius_m / std::abs(v), v, side * std::abs(v) / robot.turn_radius_m);
    } else {
      go(1.5, 0.0, 0.0);
      go(0.5 * std::numbers::pi / 0.8, 0.0, side * 0.8);
    }
    if (leg == 0) v = std::abs(v);
  }
  return truth;
}

/// Distance of a fix from where the antenna is, RMS [m], and where the first one is.
struct GpsAlone {
  double rms_m = 0.0;
  Eigen::Vector2d first = Eigen::Vector2d::Zero();
};

/// Writes wheels.csv and gps.csv, geodetic near the equator, where a degree is the same in both directions.
GpsAlone write_log(const Ordinary& robot, const std::vector<Truth>& truth, const std::filesystem::path& folder) {
  constexpr double kTrack = 0.5;
  Random random({11, robot.seed, 0, 0});
  std::string wheels = "t,left,right\n";
  std::string gps = "t,lat,lon\n";
  GpsAlone alone;
  Eigen::Vector2d slow(robot.slow_m * random.normal(), robot.slow_m * random.normal());
  const double decay = std::exp(-0.2 / robot.tau_s);
  int fixes = 0;
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const Truth& now = truth[k];
    if (k % 5 == 0) {  // 10 Hz
      const double half = 0.5 * now.w * kTrack * robot.track_scale;
      const bool slips = now.t >= robot.slip_at_s && now.t < robot.slip_at_s + 2.0;
      const bool stands = now.v == 0.0 && now.w == 0.0;
      const auto noise = [&] { return stands ? 0.0 : 0.03 * random.normal(); };
      wheels += fmt::format("{:.3f},{:.5f},{:.5f}\n", now.t, (now.v - half) * robot.left_scale + noise(),
                            (now.v + half) * robot.right_scale * (slips ? 1.4 : 1.0) + noise());
    }
    if (k % 10 == 0) {  // 5 Hz; the antenna is 0.3 m ahead
      const Eigen::Vector2d error = slow + robot.white_m * Eigen::Vector2d(random.normal(), random.normal());
      slow = decay * slow +
             std::sqrt(1.0 - decay * decay) * robot.slow_m * Eigen::Vector2d(random.normal(), random.normal());
      const Eigen::Vector2d fix =
          Eigen::Vector2d(now.x + 0.3 * std::cos(now.yaw), now.y + 0.3 * std::sin(now.yaw)) + error;
      constexpr double kMeridian = 6335439.327;  // [m], radius of curvature at the equator, WGS-84
      constexpr double kParallel = 6378137.0;
      gps += fmt::format("{:.3f},{:.10f},{:.10f}\n", now.t, fix.y() / kMeridian / kRadPerDeg,
                         8.0 + fix.x() / kParallel / kRadPerDeg);
      if (fixes == 0) alone.first = fix;
      alone.rms_m += error.squaredNorm();
      ++fixes;
    }
  }
  alone.rms_m = std::sqrt(alone.rms_m / fixes);
  write_text(folder / "wheels.csv", wheels);
  write_text(folder / "gps.csv", gps);
  write_text(folder / "robot.yaml",
             R"(source:
  plugin: csv
  files:
    - { path: wheels.csv, sensor: wheels, payload: WheelSpeeds, time: t, columns: { left_mps: left, right_mps: right } }
    - { path: gps.csv, sensor: gps, payload: GnssFix, time: t, columns: { latitude_deg: lat, longitude_deg: lon } }
sensors:
  - { name: wheels, plugin: odometry, model: differential, track_m: 0.5 }
  - { name: gps, plugin: dgps, base_p_antenna_m: [0.3, 0, 0.5])" +
                 (robot.receiver.empty() ? "" : ", receiver: " + robot.receiver) + " }\nsinks: []\n");
  return alone;
}

class OrdinaryRobots : public ::testing::TestWithParam<Ordinary> {};

TEST_P(OrdinaryRobots, AreBetterThanTheirGpsAloneWithNothingGivenButGeometry) {
  const TemporaryFolder folder;
  const std::vector<Truth> truth = drive(GetParam());
  const GpsAlone alone = write_log(GetParam(), truth, folder.path());
  double squares = 0.0;
  double nees = 0.0;
  int count = 0;
  std::optional<double> first_heading_error;
  host::Session session(
      host::Robot::load(Config::load(folder.path() / "robot.yaml"), PluginLoader({WAYMARK_PLUGIN_DIR})),
      {.observer = [&](const Snapshot& snapshot, double) {
        if (!snapshot.started()) return;
        const double t = to_seconds(snapshot.stamp().time_since_epoch());
        const Truth& now = truth[std::min(static_cast<std::size_t>(std::lround(t / kStep)), truth.size() - 1)];
        const Pose& pose = snapshot.belief().mean.T_map_base;
        const Eigen::Vector2d error = pose.p.head<2>() + alone.first - Eigen::Vector2d(now.x, now.y);
        const Eigen::Matrix2d P = pose_covariance(snapshot.belief(), snapshot.layout()).topLeftCorner<2, 2>();
        if (!first_heading_error)
          first_heading_error = std::abs(std::remainder(pose.yaw() - now.yaw, 2.0 * std::numbers::pi));
        squares += error.squaredNorm();
        nees += error.dot(P.inverse() * error);
        ++count;
      }});
  session.play();
  const host::SessionResult result = session.finish();
  EXPECT_THAT(result.failures, ::testing::IsEmpty());
  EXPECT_EQ(result.lost, "");
  ASSERT_GT(count, 3000);
  const double rms = std::sqrt(squares / count);
  RecordProperty("rms_m", fmt::format("{:.3f}", rms));
  RecordProperty("gps_rms_m", fmt::format("{:.3f}", alone.rms_m));
  RecordProperty("nees", fmt::format("{:.2f}", nees / count));
  EXPECT_LT(rms, 1.5 * alone.rms_m) << "GPS alone: " << alone.rms_m << " m, NEES " << nees / count;
  // One run is one draw of the slow error; over many runs the mean is 1 to 4.
  EXPECT_LT(nees / count, 12.0) << "RMS " << rms << " m";
  EXPECT_LT(*first_heading_error, 0.6) << "first heading [rad]";
}

INSTANTIATE_TEST_SUITE_P(Of, OrdinaryRobots,
                         ::testing::Values(
                             // The README's robot as a user had it: 15.6 m where GPS alone has 1.3 m.
                             Ordinary{"StraightLegs", 1, 1.0, 1.02, 1.0, 0.4, 0.8, 60.0, "", 1.0, 0.0, -10.0},
                             Ordinary{"Reverse", 2, 0.975, 0.99, 1.05, 0.5, 1.0, 40.0, "", -0.8, 3.0, -10.0},
                             Ordinary{"SlippingWheel", 3, 1.03, 1.0, 0.95, 0.2, 0.4, 90.0, "differential", 1.5, 0.0,
                                      100.0},
                             Ordinary{"Rtk", 4, 0.97, 1.02, 1.04, 0.012, 0.02, 60.0, "rtk_fixed", 0.6, 1.5, -10.0}),
                         [](const auto& robot) { return robot.param.name; });

}  // namespace
}  // namespace waymark::system_test
