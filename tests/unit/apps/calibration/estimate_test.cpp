// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/calibration/estimate.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <random>

#include "apps/waymark/calibration/report.hpp"

namespace waymark::calibration {
namespace {

constexpr double kDuration = 90.0;
constexpr double kWheelPeriod = 0.05;

/// What is wrong with a robot, and how noisy its sensors are.
struct Truth {
  double speed_scale = 1.02;
  double track = 0.51;
  Eigen::Vector2d antenna{0.2, -0.1};
  double gps_delay = 0.08;
  double compass_deg = 4.0;
  double compass_delay = 0.0;
  double wheel_noise = 0.01;  // of speed [m/√s]; of the rate twice that
  double scanner_deg = -3.0;
  Eigen::Vector2d scanner{0.4, 0.1};
  double scanner_delay = 0.05;
};

const char* const kRobot = R"(
sensors:
  - { name: wheels, plugin: odometry, model: differential, track_m: 0.5, speed_noise_m_per_sqrt_s: [0.02, 0], lateral_noise_m_per_sqrt_s: [0.001, 0], yaw_noise_rad_per_sqrt_s: [0.04, 0, 0] }
  - { name: gps, plugin: dgps, base_p_antenna_m: [0, 0, 0], sigma_m: 0.1 }
  - { name: compass, plugin: compass, sigma_deg: 2, base_T_sensor: { yaw_deg: 0 } }
  - { name: lidar, payload: LaserScan, base_T_sensor: { xyz_m: [0.3, 0, 0], yaw_deg: 0 } }
)";

double speed_at(double t) { return 1.0 + 0.5 * std::sin(0.5 * t); }
double rate_at(double t) { return 0.5 * std::sin(0.8 * t) + 0.3 * std::cos(0.23 * t); }

/// The true path, every millisecond.
std::vector<PathPoint> drive() {
  std::vector<PathPoint> path;
  constexpr double kStep = 1e-3;
  PathPoint at{0.0, Eigen::Vector3d::Zero()};
  for (double t = 0.0; t < kDuration; t += kStep) {
    path.push_back({t, at.pose});
    const double yaw = at.pose.z() + 0.5 * kStep * rate_at(t);
    at.pose += kStep * Eigen::Vector3d(speed_at(t) * std::cos(yaw), speed_at(t) * std::sin(yaw), rate_at(t));
  }
  return path;
}

Eigen::Vector3d pose_at(const std::vector<PathPoint>& path, double t) {
  const auto i = static_cast<std::size_t>(std::clamp(1000.0 * t, 0.0, static_cast<double>(path.size()) - 1.0));
  return path[i].pose;
}

Eigen::Vector2d turned(double angle, const Eigen::Vector2d& v) { return Eigen::Rotation2Dd(angle) * v; }

Recording record(const Truth& truth, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const std::vector<PathPoint> path = drive();
  Recording recording;
  recording.path = path;
  // The first guess is off.
  for (PathPoint& point : recording.path) point.pose += Eigen::Vector3d(0.1 * std::sin(point.t), 0.2, 0.02);
  Wheels wheels;
  wheels.sensor = "wheels";
  wheels.yaw_scales_with_speed = true;
  for (double t = 0.0; t < kDuration; t += kWheelPeriod) {
    const double white = truth.wheel_noise / std::sqrt(kWheelPeriod);
    wheels.speed.add(t, speed_at(t + 0.5 * kWheelPeriod) / truth.speed_scale + white * normal(random), kWheelPeriod);
    wheels.lateral.add(t, 0.0, kWheelPeriod);
    const double rate = rate_at(t + 0.5 * kWheelPeriod) / truth.speed_scale * truth.track / 0.5;
    wheels.rate.add(t, rate + 2.0 * white * normal(random), kWheelPeriod);
  }
  recording.wheels.push_back(wheels);
  Positions gps;
  gps.sensor = "gps";
  for (double t = 1.0; t < kDuration - 1.0; t += 0.2) {
    const Eigen::Vector3d pose = pose_at(path, t);
    const Eigen::Vector2d p = pose.head<2>() + turned(pose.z(), truth.antenna);
    gps.fixes.push_back({t + truth.gps_delay, p + 0.05 * Eigen::Vector2d(normal(random), normal(random)), 0.1});
  }
  recording.positions.push_back(gps);
  Headings compass;
  compass.sensor = "compass";
  for (double t = 1.0; t < kDuration - 1.0; t += 0.1) {
    compass.headings.push_back(
        {t + truth.compass_delay, pose_at(path, t).z() + 0.0175 * truth.compass_deg + 0.03 * normal(random), 0.0349});
  }
  recording.headings.push_back(compass);
  return recording;
}

void add_scanner(const Truth& truth, unsigned seed, Recording& recording) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const std::vector<PathPoint> path = drive();
  Scanner lidar;
  lidar.sensor = "lidar";
  lidar.lever = {0.3, 0.0};
  for (double t = 1.0; t < kDuration - 2.0; t += 0.3) {
    const Eigen::Vector3d a = pose_at(path, t);
    const Eigen::Vector3d b = pose_at(path, t + 0.3);
    const Eigen::Vector2d way = b.head<2>() + turned(b.z(), truth.scanner) - a.head<2>() - turned(a.z(), truth.scanner);
    const double mounted = truth.scanner_deg * M_PI / 180.0;
    Scanner::Motion motion{t + truth.scanner_delay, t + 0.3 + truth.scanner_delay, {}, Eigen::Matrix3d::Zero()};
    // The YAML has the scanner straight ahead.
    motion.moved << turned(-a.z() - mounted, way), b.z() - a.z();
    motion.moved += Eigen::Vector3d(0.01 * normal(random), 0.01 * normal(random), 0.003 * normal(random));
    motion.covariance.diagonal() << 1e-4, 1e-4, 9e-6;
    lidar.motions.push_back(motion);
  }
  recording.scanners.push_back(lidar);
}

struct Found {
  double change;
  double sigma;
};

std::map<std::string, Found> calibrate(const Recording& recording, const std::vector<std::string>& only,
                                       bool* converged = nullptr) {
  const Config yaml = Config::parse(kRobot);
  const Plan plan = plan_for(yaml, only);
  std::vector<Parameter> all = plan.parameters;
  all.insert(all.end(), plan.others.begin(), plan.others.end());
  const Equations equations(recording, yaml, all);
  const Estimate estimate = calibration::estimate(equations, [](const Estimate&) {});
  if (converged != nullptr) *converged = estimate.converged;
  std::map<std::string, Found> found;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    found[all[i].name()] = {estimate.change(k), estimate.sigma(k)};
  }
  return found;
}

const std::vector<std::string> kOutdoors{"wheels", "gps", "compass"};

TEST(CalibrationEstimate, FindsWhatIsWrongWithinItsSigma) {
  const Truth truth;
  const std::map<std::string, double> expected{
      {"wheels.speed_scale", truth.speed_scale - 1.0}, {"wheels.curvature_per_m", 0.0},
      {"wheels.track_m", std::log(truth.track / 0.5)}, {"gps.base_p_antenna_m[0]", truth.antenna.x()},
      {"gps.base_p_antenna_m[1]", truth.antenna.y()},  {"gps.delay_s", truth.gps_delay},
      {"compass.delay_s", truth.compass_delay},        {"compass.base_T_sensor.yaw_deg", truth.compass_deg}};
  int within = 0;
  int all = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    bool converged = false;
    std::map<std::string, Found> found = calibrate(record(truth, seed), kOutdoors, &converged);
    EXPECT_TRUE(converged) << seed;
    for (const auto& [name, value] : expected) {
      ASSERT_TRUE(found.contains(name));
      EXPECT_NEAR(found[name].change, value, 4.0 * found[name].sigma) << name << ", seed " << seed;
      within += std::abs(found[name].change - value) < 2.0 * found[name].sigma ? 1 : 0;
      ++all;
    }
  }
  EXPECT_GE(within, 40) << "of " << all << "; 95 % are expected, fewer than 40 of 48 have a probability of 0.1 %";
}

TEST(CalibrationEstimate, FindsTheLevelsOfTheNoise) {
  const Truth truth;
  std::map<std::string, Found> found = calibrate(record(truth, 1), kOutdoors);
  const auto level = [&](const std::string& name, double given) { return given * std::exp(found[name].change); };
  EXPECT_NEAR(level("gps.sigma_m", 0.1), 0.05, 0.005);
  EXPECT_NEAR(level("compass.sigma_deg", 2.0), 0.03 / M_PI * 180.0, 0.15);
  const Found& yaw = found["wheels.yaw_noise_rad_per_sqrt_s[0..1]"];
  EXPECT_NEAR(yaw.change, std::log(0.02 / 0.04), 3.0 * yaw.sigma);
  EXPECT_LT(yaw.sigma, 0.4);
}

TEST(CalibrationEquations, DerivativesAreThoseOfTheResiduals) {
  Recording recording = record(Truth{}, 1);
  add_scanner(Truth{}, 1, recording);
  const Config yaml = Config::parse(kRobot);
  const Equations equations(recording, yaml, plan_for(yaml, {}).parameters);
  const Eigen::VectorXd levels = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(equations.levels().size()));
  Eigen::VectorXd x = equations.start();
  for (Eigen::Index k = equations.first_parameter(); k < equations.size(); ++k) x(k) = 0.01;
  const Rows rows = equations.linearize(x, x, levels);
  const Eigen::MatrixXd J = rows.J.middleCols(300, 6).toDense();
  const Eigen::MatrixXd of_parameters = rows.J.rightCols(equations.size() - equations.first_parameter()).toDense();
  const auto check = [&](Eigen::Index column, const Eigen::VectorXd& derivative) {
    constexpr double kStep = 1e-6;
    Eigen::VectorXd up = x;
    Eigen::VectorXd down = x;
    up(column) += kStep;
    down(column) -= kStep;
    const Eigen::VectorXd numeric =
        (equations.linearize(up, x, levels).e - equations.linearize(down, x, levels).e) / (2.0 * kStep);
    // The bulge of an arc within 50 ms counts in the residuals only.
    EXPECT_LT((numeric - derivative).cwiseAbs().maxCoeff(), 0.01 * (1.0 + numeric.cwiseAbs().maxCoeff())) << column;
  };
  for (Eigen::Index k = 0; k < J.cols(); ++k) check(300 + k, J.col(k));
  for (Eigen::Index k = 0; k < of_parameters.cols(); ++k) check(equations.first_parameter() + k, of_parameters.col(k));
}

// A regression on what the wheels say would find a turn that is too small (errors in variables).
TEST(CalibrationEstimate, NoiseOfTheWheelsDoesNotWidenTheTrack) {
  Truth truth;
  truth.wheel_noise = 0.05;  // 0.45 rad/s in each reading, as much as the robot turns
  double sum = 0.0;
  double variance = 0.0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    std::map<std::string, Found> found = calibrate(record(truth, seed), kOutdoors);
    sum += found["wheels.track_m"].change - std::log(truth.track / 0.5);
    variance += std::pow(found["wheels.track_m"].sigma, 2);
  }
  EXPECT_LT(std::abs(sum), 3.0 * std::sqrt(variance));
}

TEST(CalibrationEstimate, FindsTheMountingOfAScannerFromItsMotion) {
  const Truth truth;
  Recording recording = record(truth, 2);
  recording.positions.clear();
  recording.headings.clear();
  add_scanner(truth, 5, recording);
  std::map<std::string, Found> found = calibrate(recording, {"wheels.track_m", "wheels.curvature", "lidar"});
  const std::map<std::string, double> expected{{"lidar.base_T_sensor.yaw_deg", truth.scanner_deg},
                                               {"lidar.delay_s", truth.scanner_delay}};
  for (const auto& [name, value] : expected) {
    EXPECT_NEAR(found[name].change, value, 3.5 * found[name].sigma) << name;
    EXPECT_GT(found[name].sigma, 0.0);
  }
  EXPECT_LT(found["lidar.base_T_sensor.yaw_deg"].sigma, 0.5);
  EXPECT_LT(found["lidar.delay_s"].sigma, 0.01);
}

TEST(CalibrationEstimate, WhatTheLogDoesNotShowKeepsItsPrior) {
  Recording recording = record(Truth{}, 1);
  recording.headings.clear();
  std::map<std::string, Found> found = calibrate(recording, kOutdoors);
  EXPECT_NEAR(found["compass.base_T_sensor.yaw_deg"].change, 0.0, 1e-6);
  EXPECT_NEAR(found["compass.base_T_sensor.yaw_deg"].sigma, 10.0, 1e-3);
}

// The receiver's error is a random walk of 0.6 m/√s; as noise of the wheels it would make the way longer.
TEST(CalibrationEstimate, PositionsThatWanderLeaveTheNoiseOfTheWheels) {
  const Truth truth;
  Recording recording = record(truth, 3);
  Positions& gps = recording.positions.front();
  gps.slow_sigma = 2.0;
  gps.slow_tau_s = 20.0;
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  Eigen::Vector2d slow(0.0, 0.0);
  const double keeps = std::exp(-0.2 / gps.slow_tau_s);
  for (Positions::Fix& fix : gps.fixes) {
    slow = keeps * slow +
           gps.slow_sigma * std::sqrt(1.0 - keeps * keeps) * Eigen::Vector2d(normal(random), normal(random));
    fix.p += slow;
  }
  std::map<std::string, Found> found = calibrate(recording, {"wheels", "gps", "compass"});
  EXPECT_EQ(found["wheels.speed_noise_m_per_sqrt_s[0..1]"].change, 0.0);
  EXPECT_NEAR(found["wheels.speed_scale"].change, truth.speed_scale - 1.0, 4.0 * found["wheels.speed_scale"].sigma);
  EXPECT_LT(found["wheels.speed_scale"].sigma, 0.05);
}

TEST(CalibrationReport, ProposesNothingThatIsImplausibleOrHasNotConverged) {
  const Config yaml = Config::parse(kRobot);
  const Plan plan = plan_for(yaml, {"wheels.speed_scale", "gps.delay_s"});
  const Values values(yaml, plan.parameters);
  ASSERT_EQ(plan.parameters.size(), 2U);
  Findings findings{"wheels", 0.0, plan.parameters, {}, {}, {}, {}};
  findings.estimate.change = Eigen::Vector2d(0.9, 0.1);  // nine times the prior's σ
  findings.estimate.sigma = Eigen::Vector2d(0.01, 0.01);
  findings.estimate.information = Eigen::Vector2d(0.99, 0.99);
  findings.estimate.converged = true;
  EXPECT_NE(table(findings, values).find("implausible"), std::string::npos);
  EXPECT_EQ(overrides(findings, values), (std::vector<Config::Override>{"sensors.gps.delay_s=0.1"}));
  findings.estimate.converged = false;
  EXPECT_TRUE(overrides(findings, values).empty());
}

TEST(CalibrationReport, ASensorThatIsAheadOfTheWheelsMakesThemLate) {
  const Config yaml = Config::parse(kRobot);
  const Plan plan = plan_for(yaml, {"gps.delay_s", "compass.delay_s"});
  const Values values(yaml, plan.parameters);
  Findings findings{"wheels", 0.0, plan.parameters, {}, {}, {}, {}};
  findings.estimate.change = Eigen::Vector2d(-0.25, 0.125);
  findings.estimate.sigma = Eigen::Vector2d(0.01, 0.01);
  findings.estimate.information = Eigen::Vector2d(0.99, 0.99);
  findings.estimate.converged = true;
  EXPECT_EQ(overrides(findings, values),
            (std::vector<Config::Override>{"sensors.compass.delay_s=0.375", "sensors.gps.delay_s=0",
                                           "sensors.wheels.delay_s=0.25"}));
  EXPECT_NE(yaml_block(findings, values, "").find("delay_s: 0.25  # ± 0.010, was 0.000; gps is ahead of it by so much"),
            std::string::npos);
}

TEST(CalibrationEstimate, OutliersHardlyMoveIt) {
  const Truth truth;
  Recording recording = record(truth, 1);
  const double before = calibrate(recording, kOutdoors)["gps.base_p_antenna_m[0]"].change;
  for (std::size_t i = 100; i < 110; ++i) recording.positions[0].fixes[i].p.x() += 30.0;
  const Found after = calibrate(recording, kOutdoors)["gps.base_p_antenna_m[0]"];
  EXPECT_NEAR(after.change, before, 3.0 * after.sigma);
}

TEST(CalibrationIntegral, IsExactForMeansAndTrapezoidsAndKnowsGaps) {
  Integral samples;
  for (int i = 0; i <= 10; ++i) samples.add(0.1 * i, 0.1 * i, 0.0);
  EXPECT_NEAR(samples.mean(0.2, 0.6).value(), 0.4, 1e-12);
  EXPECT_FALSE(samples.mean(-0.1, 0.5));
  samples.add(2.0, 1.0, 0.0);
  EXPECT_FALSE(samples.mean(0.5, 1.5)) << "a gap";
  Integral means;
  for (int i = 0; i < 10; ++i) means.add(0.1 * i, i, 0.1);
  EXPECT_NEAR(means.mean(0.2, 0.4).value(), 2.5, 1e-9);
}

}  // namespace
}  // namespace waymark::calibration
