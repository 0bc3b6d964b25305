// SPDX-License-Identifier: Apache-2.0
#include "estimation/georeference.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "estimation/ekf.hpp"
#include "particles/particle_filter.hpp"
#include "unit/core/beliefs.hpp"
#include "unit/core/toy_map.hpp"

namespace waymark {
namespace {

using Motion = StateLayout::Motion;

/// A layout with a sensor's block before the georeference, and random beliefs on it.
class GeoreferenceOf : public ::testing::TestWithParam<Motion> {
 protected:
  Belief random_belief() {
    Belief belief{{}, test::random_state(layout, random), test::random_covariance(layout.size(), random)};
    return belief;
  }
  /// `state` moved by a small step of one error state.
  NavState moved(const NavState& state, int i, double by) const {
    NavState result = state;
    ErrorVector step = ErrorVector::Zero(layout.size());
    step[i] = by;
    boxplus(result, step, layout);
    return result;
  }

  StateLayout layout{
      GetParam(),
      {{"wheels", test::block_of(2)},
       {"georeference", estimation::Georeference::block(GetParam(), GeoreferenceSettings{true, 0.0, 0.0})}}};
  estimation::Georeference georeference{layout, 1};
  Random random = test::stream(41);
};

TEST_P(GeoreferenceOf, ComposesThePoseAndLeavesTheRest) {
  const NavState state = random_belief().mean;
  const NavState enu = georeference.in_enu(state);
  const Pose expected = georeference.T_enu_map(state) * state.T_map_base;
  EXPECT_LT((enu.T_map_base.p - expected.p).norm(), 1e-12);
  EXPECT_LT(enu.T_map_base.q.angularDistance(expected.q), 1e-12);
  EXPECT_EQ(enu.v_base, state.v_base);
  EXPECT_EQ(enu.block, state.block);
}

TEST_P(GeoreferenceOf, CovarianceInEnuIsThatOfTheNumericalJacobian) {
  constexpr double kStep = 1e-6;
  const Belief belief = random_belief();
  const NavState center = georeference.in_enu(belief.mean);
  Eigen::MatrixXd J(layout.size(), layout.size());
  for (int i = 0; i < layout.size(); ++i) {
    J.col(i) = (boxminus(georeference.in_enu(moved(belief.mean, i, kStep)), center, layout) -
                boxminus(georeference.in_enu(moved(belief.mean, i, -kStep)), center, layout)) /
               (2.0 * kStep);
  }
  Belief enu = belief;
  georeference.to_enu(enu);
  const Eigen::MatrixXd expected = J * belief.P * J.transpose();
  EXPECT_LT((enu.P - expected).cwiseAbs().maxCoeff(), 1e-5 * expected.cwiseAbs().maxCoeff());
}

TEST_P(GeoreferenceOf, CarriesTheJacobianOfAFixOverToPoseAndBlock) {
  constexpr double kStep = 1e-6;
  const Belief belief = random_belief();
  const test::PositionModel fix({3.0, -2.0}, 0.5);
  const auto residual = [&](const NavState& state) {
    Linearization model;
    const NavState enu = georeference.in_enu(state);
    fix.linearize({enu, nullptr}, model);
    return Eigen::VectorXd(model.residual);
  };
  Eigen::MatrixXd H(2, layout.size());
  for (int i = 0; i < layout.size(); ++i) {
    H.col(i) = -(residual(moved(belief.mean, i, kStep)) - residual(moved(belief.mean, i, -kStep))) / (2.0 * kStep);
  }
  Linearization model;
  const NavState enu = georeference.in_enu(belief.mean);
  fix.linearize({enu, nullptr}, model);
  estimation::StateJacobian scattered;
  scattered.reset(model.rows(), layout.size());
  georeference.scatter(belief.mean, 0, model, scattered);
  estimation::ekf::Innovation innovation;
  estimation::ekf::innovate(belief, model, scattered, innovation);
  const Eigen::MatrixXd P = belief.P;
  const Eigen::MatrixXd expected = P * H.transpose();
  EXPECT_LT((innovation.PHt - expected).cwiseAbs().maxCoeff(), 1e-6 * expected.cwiseAbs().maxCoeff());
}

TEST_P(GeoreferenceOf, TakesOverTheStartSoThatTheMapBeginsAtACertainOrigin) {
  Belief prior = random_belief();
  prior.mean.T_map_base = Pose::planar(12.0, -5.0, 0.7);
  const Eigen::Matrix3d before = pose_covariance(prior, layout);
  georeference.take_over_start(prior);
  EXPECT_LT(prior.mean.T_map_base.p.norm(), 1e-12);
  EXPECT_NEAR(prior.mean.T_map_base.yaw(), 0.0, 1e-12);
  EXPECT_EQ(pose_covariance(prior, layout), Eigen::Matrix3d::Zero());
  georeference.to_enu(prior);
  EXPECT_LT((prior.mean.T_map_base.p - Eigen::Vector3d(12.0, -5.0, 0.0)).norm(), 1e-12);
  EXPECT_NEAR(prior.mean.T_map_base.yaw(), 0.7, 1e-12);
  EXPECT_LT((pose_covariance(prior, layout) - before).cwiseAbs().maxCoeff(), 1e-12)
      << "what was not known of the start is not known of the pose on the Earth";
}

TEST_P(GeoreferenceOf, APointFarFromTheOriginIsLessCertainByTheYaw) {
  Belief belief = random_belief();
  belief.P.setZero();
  const int yaw = layout.size() - 1;
  belief.P(yaw, yaw) = 0.01 * 0.01;
  const Eigen::Matrix2d P = georeference.point_covariance(belief, {100.0, 0.0});
  EXPECT_NEAR(std::sqrt(P.trace()), 1.0, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Motions, GeoreferenceOf, ::testing::Values(Motion::planar, Motion::spatial),
                         [](const auto& which) { return which.param == Motion::planar ? "planar" : "spatial"; });

/// One particle that starts with a wrong heading, and has exact odometry and exact fixes.
TEST(GeoreferenceFilter, FixesRotateTheMapAndLeaveThePathInItAlone) {
  const StateLayout layout(
      Motion::planar,
      {{"gps", {}},
       {"georeference", estimation::Georeference::block(Motion::planar, GeoreferenceSettings{true, 0.0, 0.0})}});
  const estimation::ProcessModel process(layout, {{0.01, 0.01, 0.0}, {0.0, 0.0, 0.01}});
  particles::ParticleFilter filter(process, {std::make_shared<test::ToyModule>()}, {},
                                   estimation::Georeference(layout, 1));
  const double wrong_by = 0.2;
  Belief prior;
  prior.mean.T_map_base = Pose::planar(0.0, 0.0, wrong_by);  // the robot really faces east
  prior.mean.v_base.x() = 1.0;
  prior.mean.block = BlockVector::Zero(3);
  prior.P = ErrorMatrix::Zero(layout.size(), layout.size());
  prior.P.diagonal().head<3>() << 0.01, 0.01, 0.09;
  filter.start(prior, true);

  particles::UpdatePolicy gps;
  gps.absolute = true;
  for (int k = 1; k <= 100; ++k) {
    const double t = 0.2 * k;
    filter.predict(test::at(t), false);
    filter.update(test::TwistModel({1.0, 0.0, 0.0}, {0.01, 0.01, 0.01}), {});
    test::Sighting sighting;
    for (const Eigen::Vector2d& landmark : {Eigen::Vector2d(12.0, 3.0), Eigen::Vector2d(5.0, -4.0)})
      sighting.see(Pose::planar(t, 0.0, 0.0), landmark, {0.0, 0.0});
    filter.map(std::vector<particles::MappingInput>{{0, &sighting, 1.0, true}}, 0);
    filter.update(test::PositionModel({t, 0.0}, 0.1), gps);
  }
  const particles::Particle& particle = filter.particles().front();
  EXPECT_NEAR(particle.belief.mean.T_map_base.yaw(), 0.0, 0.05) << "straight on in its own map";
  EXPECT_NEAR(filter.T_enu_map(particle).yaw(), 0.0, 0.03) << "the fixes rotate the map";
  EXPECT_NEAR(filter.mixture().mean.T_map_base.p.x(), 20.0, 0.2);
  EXPECT_NEAR(filter.mixture().mean.T_map_base.p.y(), 0.0, 0.2);
}

TEST(GeoreferenceFilter, InflatingSetsTheMapFreeAndNotTheWayInIt) {
  const StateLayout layout(
      Motion::planar,
      {{"gps", {}},
       {"georeference", estimation::Georeference::block(Motion::planar, GeoreferenceSettings{true, 0.0, 0.0})}});
  const estimation::ProcessModel process(layout, {});
  particles::ParticleFilter filter(process, {}, {}, estimation::Georeference(layout, 1));
  Belief prior;
  prior.mean.block = BlockVector::Zero(3);
  prior.P = ErrorMatrix::Zero(layout.size(), layout.size());
  filter.start(prior, true);
  filter.inflate_pose({.position = 4.0, .yaw = 0.1});
  EXPECT_EQ(pose_covariance(filter.particles().front().belief, layout), Eigen::Matrix3d::Zero());
  EXPECT_NEAR(filter.mixture().P(0, 0), 4.0, 1e-12);
}

}  // namespace
}  // namespace waymark
