// SPDX-License-Identifier: Apache-2.0
#include "estimation/ekf.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <vector>

#include "estimation/process_model.hpp"
#include "unit/core/beliefs.hpp"

namespace waymark {
namespace {

using Motion = StateLayout::Motion;

/// A measurement of position and velocity in the plane, linear in both.
struct LinearMeasurement {
  Eigen::Matrix2d on_position;
  Eigen::Matrix2d on_velocity;
  Eigen::Vector2d z;
  double variance;

  Linearization at(const NavState& state) const {
    Linearization model;
    model.reset(2, 0);
    model.residual = z - on_position * state.T_map_base.p.head<2>() - on_velocity * state.v_base.head<2>();
    model.R = variance * Eigen::Matrix2d::Identity();
    model.position().leftCols<2>() = on_position;
    model.velocity().leftCols<2>() = on_velocity;
    return model;
  }
  Eigen::Matrix<double, 2, 6> jacobian() const {
    Eigen::Matrix<double, 2, 6> H = Eigen::Matrix<double, 2, 6>::Zero();
    H.leftCols<2>() = on_position;
    H.middleCols<2>(3) = on_velocity;
    return H;
  }
};

// With known heading and no turning the system is linear, so the last state's marginal of all states conditioned at
// once on all measurements is what the filter must find.
TEST(Ekf, ReproducesTheBatchSolutionOfALinearGaussianCase) {
  constexpr int kSteps = 25;
  constexpr double kDt = 0.2;
  const StateLayout layout(Motion::planar, {});
  const estimation::ProcessModel process(layout, {{0.5, 0.3, 0.0}, {0.0, 0.0, 0.0}});
  Random random = test::stream(11);

  Belief belief;
  belief.mean.T_map_base = Pose::planar(1.0, 2.0, 0.6);
  belief.mean.v_base = {1.0, 0.2, 0.0};
  belief.P = ErrorMatrix::Zero(6, 6);
  belief.P.diagonal() << 4.0, 4.0, 0.0, 1.0, 1.0, 0.0;
  Belief noise_only = belief;
  noise_only.P.setZero();
  process.predict(noise_only, test::at(kDt), false);
  const Eigen::MatrixXd Q = noise_only.P;
  const Eigen::MatrixXd F = process.transition(belief.mean, kDt);

  Eigen::MatrixXd joint = Eigen::MatrixXd::Zero(6 * kSteps, 6 * kSteps);
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(2 * kSteps, 6 * kSteps);
  Eigen::VectorXd nu(2 * kSteps);
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(2 * kSteps, 2 * kSteps);
  Eigen::MatrixXd P = belief.P;
  NavState prior = belief.mean;
  for (int k = 0; k < kSteps; ++k) {
    P = F * P * F.transpose() + Q;
    process.predict_mean(prior, kDt);
    joint.block(6 * k, 6 * k, 6, 6) = P;
    for (int j = 0; j < k; ++j) {
      joint.block(6 * k, 6 * j, 6, 6) = F * joint.block(6 * (k - 1), 6 * j, 6, 6);
      joint.block(6 * j, 6 * k, 6, 6) = joint.block(6 * k, 6 * j, 6, 6).transpose();
    }
    LinearMeasurement m;
    m.on_position << random.normal(), random.normal(), random.normal(), random.normal();
    m.on_velocity << random.normal(), random.normal(), random.normal(), random.normal();
    m.z = 5.0 * test::normals(2, random);
    m.variance = test::uniform(random, 0.1, 2.0);
    H.block(2 * k, 6 * k, 2, 6) = m.jacobian();
    R.block(2 * k, 2 * k, 2, 2) = m.variance * Eigen::Matrix2d::Identity();
    nu.segment(2 * k, 2) = m.at(prior).residual;

    process.predict(belief, belief.stamp + from_seconds(kDt), false);
    estimation::ekf::Innovation innovation;
    test::innovate(belief, layout, -1, m.at(belief.mean), innovation);
    ASSERT_TRUE(innovation.finite);
    estimation::ekf::apply(belief, layout, innovation);
  }
  const Eigen::MatrixXd gain = joint * H.transpose() * (H * joint * H.transpose() + R).inverse();
  NavState expected = prior;
  boxplus(expected, (gain * nu).tail(6), layout);
  const Eigen::MatrixXd posterior = joint - gain * H * joint;
  EXPECT_LT(boxminus(belief.mean, expected, layout).norm(), 1e-9);
  EXPECT_LT((belief.P - posterior.bottomRightCorner(6, 6)).cwiseAbs().maxCoeff(), 1e-9);
}

class Scatter : public ::testing::TestWithParam<Motion> {};

TEST_P(Scatter, PutsEveryPartOfTheModelAtItsPlace) {
  const StateLayout layout(GetParam(), {{"wheels", test::block_of(2)}, {"gps", test::block_of(3)}});
  Random random = test::stream(12);
  Belief belief{{}, test::random_state(layout, random), test::random_covariance(layout.size(), random)};
  Linearization model;
  model.reset(4, 3);
  model.residual = test::normals(4, random);
  model.R = Eigen::MatrixXd::Identity(4, 4);
  Eigen::MatrixXd core = Eigen::MatrixXd::Zero(4, kCoreStates);
  for (int i = 0; i < kCoreStates; ++i) core.col(i) = test::normals(4, random);
  core.middleCols(6, 3).setZero();  // the velocity is not requested
  model.position() = core.middleCols(0, 3);
  model.attitude() = core.middleCols(3, 3);
  model.angular_rate() = core.middleCols(9, 3);
  Eigen::MatrixXd own(4, 3);
  for (int i = 0; i < 3; ++i) own.col(i) = test::normals(4, random);
  model.block() = own;

  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(4, layout.size());
  for (int i = 0; i < kCoreStates; ++i) {
    if (layout.active(i) >= 0) H.col(layout.active(i)) = core.col(i);
  }
  H.rightCols(3) = own;  // gps stands last
  estimation::ekf::Innovation innovation;
  test::innovate(belief, layout, 1, model, innovation);
  const Eigen::MatrixXd P = belief.P;
  EXPECT_LT((innovation.PHt - P * H.transpose()).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((innovation.S - (H * P * H.transpose() + Eigen::MatrixXd::Identity(4, 4))).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_TRUE(innovation.finite);
}

INSTANTIATE_TEST_SUITE_P(Motions, Scatter, ::testing::Values(Motion::planar, Motion::spatial));

TEST(Ekf, ReportsWhatIsNotFinite) {
  const StateLayout layout(Motion::planar, {});
  Belief belief;
  belief.P = ErrorMatrix::Identity(6, 6);
  Linearization model;
  model.reset(1, 0);
  model.R(0, 0) = 1.0;
  model.position()(0, 0) = std::nan("");
  estimation::ekf::Innovation innovation;
  test::innovate(belief, layout, -1, model, innovation);
  EXPECT_FALSE(innovation.finite);
  model.position()(0, 0) = 1.0;
  model.residual[0] = INFINITY;
  test::innovate(belief, layout, -1, model, innovation);
  EXPECT_FALSE(innovation.finite);
  model.residual[0] = 0.0;
  model.R(0, 0) = -2.0;
  test::innovate(belief, layout, -1, model, innovation);
  EXPECT_FALSE(innovation.finite);
}

// Noise from a tenth of a millimetre to ten kilometres, on a prior of a kilometre, in any order.
TEST(Ekf, CovarianceStaysPositiveOverManyUpdatesOfExtremeNoise) {
  const StateLayout layout(Motion::planar, {});
  const estimation::ProcessModel process(layout, {{1.0, 0.3, 0.0}, {0.0, 0.0, 0.5}});
  Random random = test::stream(13);
  Belief belief;
  belief.P = ErrorMatrix::Zero(6, 6);
  belief.P.diagonal() << 1e6, 1e6, 10.0, 100.0, 100.0, 10.0;
  estimation::ekf::Innovation innovation;
  for (int k = 1; k <= 100'000; ++k) {
    process.predict(belief, belief.stamp + from_seconds(0.01), false);
    LinearMeasurement m;
    m.on_position = (k % 2) * Eigen::Matrix2d::Identity();
    m.on_velocity = Eigen::Matrix2d::Identity() - m.on_position;
    const double sigma = std::pow(10.0, test::uniform(random, -4.0, 4.0));
    m.variance = sigma * sigma;
    const NavState& mean = belief.mean;
    m.z = m.on_position * mean.T_map_base.p.head<2>() + m.on_velocity * mean.v_base.head<2>();
    test::innovate(belief, layout, -1, m.at(belief.mean), innovation);
    ASSERT_TRUE(innovation.finite) << k;
    estimation::ekf::apply(belief, layout, innovation);
    ASSERT_LT(test::asymmetry(belief.P), 1e-9 * belief.P.norm()) << k;
    if (k % 10 == 0) {
      ASSERT_GT(test::smallest_eigenvalue(belief.P), -1e-12 * belief.P.norm()) << k;
    }
  }
}

/// A speedometer whose reading z is too small by an unknown share, its state: v = (1 + s) z.
Linearization speedometer(const NavState& state, double z, double variance, bool considered) {
  Linearization model;
  model.reset(1, 1);
  model.residual << (1.0 + state.block[0]) * z - state.v_base.x();
  model.R << variance;
  model.velocity()(0, 0) = 1.0;
  model.block()(0, 0) = -z;
  if (considered) model.mark_block_considered();
  return model;
}

/// A straight ride at 100 Hz whose speed is known from such a speedometer, with a tenth of noise.
struct Ride {
  StateLayout layout{Motion::planar, {{"speedometer", test::block_of(1)}}};
  estimation::ProcessModel process{layout, {{1.0, 0.0, 0.0}, {0.0, 0.0, 0.0}}};
  Random random;
  Belief belief;
  estimation::ekf::Innovation innovation;

  explicit Ride(std::uint64_t seed) : random(test::stream(seed)) {
    belief.mean.block.setZero(1);
    belief.P = ErrorMatrix::Zero(7, 7);
    belief.P.diagonal() << 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.01;
  }
  /// It reads 1 m/s.
  void read(bool considered) {
    process.predict(belief, belief.stamp + from_seconds(0.01), false);
    const double z = 1.0 + 0.1 * random.normal();
    test::innovate(belief, layout, 0, speedometer(belief.mean, z, 0.01, considered), innovation);
    estimation::ekf::apply(belief, layout, innovation);
  }
};

// The speed is known from the speedometer alone, so its scale is not observable.
TEST(Ekf, AConsideredBlockIsNotEstimatedFromTheNoiseOfItsOwnReading) {
  Ride considered(21);
  Ride estimated(21);
  for (int k = 1; k <= 3000; ++k) {
    considered.read(true);
    estimated.read(false);
  }
  EXPECT_EQ(considered.belief.P(6, 6), 0.01);
  EXPECT_GT(test::smallest_eigenvalue(considered.belief.P), -1e-12);
  EXPECT_EQ(considered.belief.mean.block[0], 0.0);
  EXPECT_LT(estimated.belief.mean.block[0], -0.02);  // why it must be considered
}

TEST(Ekf, AConsideredBlockIsEstimatedFromOtherMeasurements) {
  Ride ride(22);
  constexpr double kSpeed = 1.1;
  for (int k = 1; k <= 3000; ++k) {
    ride.read(true);
    if (k % 100 != 0) continue;
    LinearMeasurement fix{Eigen::Matrix2d::Identity(), Eigen::Matrix2d::Zero(), {0.01 * k * kSpeed, 0.0}, 1e-4};
    test::innovate(ride.belief, ride.layout, -1, fix.at(ride.belief.mean), ride.innovation);
    estimation::ekf::apply(ride.belief, ride.layout, ride.innovation);
  }
  EXPECT_NEAR(ride.belief.mean.block[0], 0.1, 3.0 * std::sqrt(ride.belief.P(6, 6)));
  EXPECT_LT(std::sqrt(ride.belief.P(6, 6)), 0.01);
}

TEST(Ekf, StopAndReleaseTouchTheTwistOnly) {
  const StateLayout layout(Motion::planar, {{"gps", test::block_of(1)}});
  Random random = test::stream(14);
  Belief belief{{}, test::random_state(layout, random), test::random_covariance(7, random)};
  const Belief before = belief;
  estimation::ekf::stop(belief, layout);
  EXPECT_EQ(belief.mean.v_base, Eigen::Vector3d::Zero());
  EXPECT_EQ(belief.mean.w_base, Eigen::Vector3d::Zero());
  EXPECT_TRUE(belief.P.middleRows(3, 3).isZero(0.0));
  EXPECT_TRUE(belief.P.middleCols(3, 3).isZero(0.0));
  estimation::ekf::release(belief, layout, 3.0, 0.5);
  EXPECT_EQ(belief.P.diagonal().segment(3, 3), Eigen::Vector3d(9.0, 9.0, 0.25));
  EXPECT_TRUE(belief.P.block(0, 3, 3, 3).isZero(0.0));
  EXPECT_EQ(belief.P.topLeftCorner(3, 3), before.P.topLeftCorner(3, 3));
  EXPECT_EQ(belief.P(6, 6), before.P(6, 6));
  EXPECT_EQ(belief.mean.T_map_base.p, before.mean.T_map_base.p);
}

}  // namespace
}  // namespace waymark
