// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "attitude_filter.hpp"
#include "imu_simulator.hpp"

namespace waymark::imu {
namespace {

/// A magnet held beside the sensor from 20 s to 50 s: stronger and turned by 60°.
Eigen::Vector3d with_magnet(double t) {
  Eigen::Vector3d earth(0.0, 20e-6, -45e-6);
  if (t < 20.0 || t > 50.0) return earth;
  return 1.3 * (so3::exp({0.0, 0.0, 60.0 * kDegree}) * earth);
}

double worst_heading(const AttitudeSettings& settings, const std::function<Eigen::Vector3d(double)>& field) {
  AttitudeFilter filter(settings);
  ImuSimulator sim;
  sim.field = field;
  double worst = 0.0;
  sim.run(filter, 80.0, [&] { worst = std::max(worst, std::abs(error_of(filter, sim).z())); });
  return worst;
}

TEST(Magnetometer, AFieldOfWrongStrengthDoesNotTurnTheHeading) {
  AttitudeSettings credulous;
  credulous.field_strength_limit = 1e3;
  EXPECT_LT(worst_heading({}, with_magnet), 1.0 * kDegree);
  EXPECT_GT(worst_heading(credulous, with_magnet), 20.0 * kDegree) << "the magnet is too weak to show anything";
}

TEST(Magnetometer, AFieldOfWrongDipDoesNotTurnTheHeading) {
  // The same strength, 25° less dip, 60° beside.
  const auto field = [](double t) -> Eigen::Vector3d {
    Eigen::Vector3d earth(0.0, 20e-6, -45e-6);
    if (t < 20.0 || t > 50.0) return earth;
    return so3::exp({0.0, 0.0, 60.0 * kDegree}) * (so3::exp({25.0 * kDegree, 0.0, 0.0}) * earth);
  };
  AttitudeSettings credulous;
  credulous.field_dip_limit = 1e3;
  EXPECT_LT(worst_heading({}, field), 1.0 * kDegree);
  EXPECT_GT(worst_heading(credulous, field), 20.0 * kDegree) << "the field is too weak to show anything";
}

TEST(Magnetometer, CountsWhatItRefuses) {
  AttitudeFilter filter;
  ImuSimulator sim;
  sim.field = with_magnet;
  sim.run(filter, 19.9);
  EXPECT_EQ(filter.counts().disturbed, 0u);
  EXPECT_FALSE(filter.disturbed());
  const double sigma = std::sqrt(filter.covariance()(2, 2));
  sim.run(filter, 20.0);
  EXPECT_TRUE(filter.disturbed());
  EXPECT_GT(filter.field().disturbance(), 1.0);
  EXPECT_NEAR(static_cast<double>(filter.counts().disturbed), 19.9 / sim.dt, 0.2 / sim.dt);
  EXPECT_GT(std::sqrt(filter.covariance()(2, 2)), sigma) << "without a field the heading gets less certain";
  sim.run(filter, 12.0);
  EXPECT_FALSE(filter.disturbed());
}

TEST(Magnetometer, AnotherFieldThatStaysWhileItTurnsBecomesTheReference) {
  const auto field = [](double t) -> Eigen::Vector3d {
    return (t < 20.0 ? 1.0 : 0.8) * Eigen::Vector3d(0.0, 20e-6, -45e-6);
  };
  for (const bool turning : {true, false}) {
    AttitudeFilter filter;
    ImuSimulator sim;
    sim.field = field;
    if (turning) sim.rate = [](double t) { return Eigen::Vector3d(0.0, 0.0, std::sin(0.5 * t) > 0.0 ? 1.0 : -1.0); };
    sim.run(filter, 25.0);
    EXPECT_TRUE(filter.disturbed());
    sim.run(filter, 45.0);
    EXPECT_EQ(filter.disturbed(), !turning) << "a magnet that moves along is steady only as long as nothing turns";
    EXPECT_NEAR(filter.field().strength(), (turning ? 0.8 : 1.0) * field(0.0).norm(), 1e-6);
  }
}

TEST(Magnetometer, TheReferenceFollowsAFieldThatDrifts) {
  AttitudeFilter filter;
  ImuSimulator sim;
  sim.field = [](double t) -> Eigen::Vector3d { return (1.0 + 0.001 * t) * Eigen::Vector3d(0.0, 20e-6, -45e-6); };
  sim.run(filter, 200.0);
  EXPECT_EQ(filter.counts().disturbed, 0u);
  EXPECT_NEAR(filter.field().strength(), 1.18 * std::hypot(20e-6, 45e-6), 0.01 * 5e-5);
  EXPECT_NEAR(filter.field().dip(), std::atan2(45.0, 20.0), 1e-3);
}

TEST(Magnetometer, NeverTurnsRollAndPitch) {
  // A wrong direction with the right strength and dip: the heading goes wrong, and nothing else may.
  AttitudeFilter filter;
  ImuSimulator sim;
  sim.field = [](double t) -> Eigen::Vector3d {
    return so3::exp({0.0, 0.0, t < 5.0 ? 0.0 : 20.0 * kDegree}) * Eigen::Vector3d(0.0, 20e-6, -45e-6);
  };
  double worst = 0.0;
  sim.run(filter, 30.0, [&] { worst = std::max(worst, tilt_error(filter, sim)); });
  EXPECT_EQ(filter.counts().disturbed, 0u);
  EXPECT_GT(std::abs(error_of(filter, sim).z()), 3.0 * kDegree);
  EXPECT_LT(worst, 0.005 * kDegree);  // not zero: the bias is corrected along
}

TEST(Magnetometer, CorrectsAHeadingThatDrifted) {
  AttitudeFilter filter;
  ImuSimulator sim;
  sim.bias.z() = 0.8 * kDegree;
  sim.rate = [](double t) { return Eigen::Vector3d(0.0, std::sin(3.0 * t), 0.0); };  // no rest to learn the bias at
  sim.run(filter, 2.0);
  sim.has_field = false;
  sim.run(filter, 40.0);
  EXPECT_GT(std::abs(error_of(filter, sim).z()), 10.0 * kDegree);
  sim.has_field = true;
  sim.run(filter, 60.0);
  EXPECT_NEAR(filter.gyro_bias().z(), sim.bias.z(), 0.1 * kDegree);
  EXPECT_LT(std::abs(error_of(filter, sim).z()), 1.0 * kDegree);
}

}  // namespace
}  // namespace waymark::imu
