// SPDX-License-Identifier: Apache-2.0
// needs plugins: dgps, odometry
#include "estimation/smoother.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <vector>

#include "particles/particle_filter.hpp"
#include "unit/core/fusion_robot.hpp"
#include "unit/core/toy_map.hpp"

namespace waymark {
namespace {

using namespace test;  // NOLINT(google-build-using-namespace): the robot's parts

/// Forty seconds straight east with fixes, but for ten seconds in the middle.
std::vector<Measurement> outage() {
  std::vector<Measurement> log;
  Random random = stream(33);
  drive(log, 0.0, 40.0, 1.0, 0.0);
  for (int k = 0; k < 40; ++k) {
    if (k > 15 && k < 25) continue;
    log.push_back(fix(k + 0.05, k + 0.05 + 0.1 * random.normal(), 0.1 * random.normal()));
  }
  return in_order(log);
}

// A function, since constants of a header may be set later than those of this file.
std::string smooth() { return kAtOrigin + "filter: { smooth: true }\nsensors:\n" + kWheels + gps(); }

TEST(Smoother, EndsAsTheFilterEnds) {
  FusionRobot robot(smooth());
  robot.play(outage());
  const SmoothedPose last = robot.fusion().report().smoothed.back();
  EXPECT_EQ(last.stamp, robot.filter().stamp());
  EXPECT_LT((last.T_map_base.p - robot.pose().p).norm(), 1e-12);
  EXPECT_LT((last.P - robot.pose_P()).norm(), 1e-12);
}

TEST(Smoother, HasNoSawtoothAndIsMoreCertainThanTheFilter) {
  FusionRobot robot(smooth());
  robot.play(outage());
  const std::vector<SmoothedPose> smoothed = robot.fusion().report().smoothed;
  double step_filtered = 0.0;
  double step_smoothed = 0.0;
  double middle_filtered = 0.0;
  double middle_smoothed = 0.0;
  std::size_t k = 0;
  const Seen* before = nullptr;
  for (const Seen& seen : robot.seen()) {
    while (k + 1 < smoothed.size() && smoothed[k].stamp < seen.belief.stamp) ++k;
    const Eigen::Matrix3d P = pose_covariance(seen.belief, robot.fusion().layout());
    EXPECT_LE(smoothed[k].P.trace(), P.trace() * (1.0 + 1e-9)) << seen.stamp;
    if (std::abs(seen.stamp - 24.0) < 0.01) {
      middle_filtered = P(1, 1);
      middle_smoothed = smoothed[k].P(1, 1);
    }
    if (before != nullptr && seen.stamp > 20.0 && seen.stamp < 30.0 && k > 0) {
      step_filtered =
          std::max(step_filtered, std::abs((seen.belief.mean.T_map_base.p - before->belief.mean.T_map_base.p).y()));
      step_smoothed = std::max(step_smoothed, std::abs((smoothed[k].T_map_base.p - smoothed[k - 1].T_map_base.p).y()));
    }
    before = &seen;
  }
  EXPECT_LT(middle_smoothed, 0.3 * middle_filtered);
  EXPECT_LT(step_smoothed, step_filtered);
}

TEST(Smoother, CarriesNothingOverAReacquisitionThatSharesItsStamp) {
  FusionRobot robot(kAtOrigin + "filter: { smooth: true }\nsensors:\n" + kWheels +
                    gps("jump_sigmas: 0, max_consecutive_rejections: 5"));
  std::vector<Measurement> log;
  drive(log, 0.0, 20.0, 1.0, 0.0);
  for (int k = 0; k < 20; ++k) log.push_back(fix(k, k, k < 10 ? 0.0 : 50.0));  // with a twist at the same stamp
  robot.play(in_order(log));
  ASSERT_NEAR(robot.pose().p.y(), 50.0, 1.0);
  for (const SmoothedPose& pose : robot.fusion().report().smoothed) {
    if (pose.stamp >= at(9.0)) continue;
    EXPECT_NEAR(pose.T_map_base.p.y(), 0.0, 0.5);
  }
}

TEST(Smoother, IncrementsAloneLeaveNothingToSmooth) {
  FusionRobot robot(
      "initial: { x_m: 0, y_m: 0, yaw_deg: 0 }\nfilter: { smooth: true }\nsensors:\n"
      "  - { name: wheels, plugin: odometry, model: increment, still_speed_mps: 0, still_rate_radps: 0, " +
      test::kNoScale + " }\n");
  std::vector<Measurement> log;
  Random random = stream(35);
  for (int k = 0; k < 100; ++k) {
    auto step = std::make_shared<PoseIncrement>();
    step->interval_s = 0.2;
    step->x_m = 0.2 + 0.1 * random.normal();
    step->y_m = 0.0;
    step->yaw_rad = 0.2 * random.normal();
    log.push_back(reading(0.2 * k, 0, step));
  }
  robot.play(log);
  const std::vector<SmoothedPose> smoothed = robot.fusion().report().smoothed;
  ASSERT_EQ(smoothed.size(), robot.seen().size());
  for (std::size_t k = 0; k < smoothed.size(); ++k) {
    const Pose& filtered = robot.seen()[k].belief.mean.T_map_base;
    EXPECT_LT((smoothed[k].T_map_base.p - filtered.p).norm(), 1e-6) << k;
    EXPECT_NEAR(smoothed[k].T_map_base.yaw(), filtered.yaw(), 1e-6) << k;
  }
}

/// The joint Gaussian of all steps, conditioned on all measurements at once, for a case that is linear: the heading is
/// known and the robot drives straight.
TEST(Smoother, IsTheBatchSolutionOfALinearCase) {
  const StateLayout layout(StateLayout::Motion::planar, {});
  const estimation::ProcessModel process(layout, {{0.5, 0.2, 0.0}, {0.0, 0.0, 0.0}});
  constexpr int kSteps = 12;
  constexpr int n = 6;
  const double dt = 0.2;
  Belief prior;
  prior.mean.v_base.x() = 1.0;
  prior.mean.block = BlockVector::Zero(0);
  prior.P = ErrorMatrix::Zero(n, n);
  prior.P.diagonal() << 1.0, 1.0, 0.0, 0.25, 0.25, 0.0;

  // Batch: the means of the chain, and the covariance between any two steps.
  Eigen::MatrixXd joint = Eigen::MatrixXd::Zero(n * kSteps, n * kSteps);
  Belief step = prior;
  std::vector<NavState> means;
  for (int k = 0; k < kSteps; ++k) {
    const ErrorMatrix F = process.transition(step.mean, dt);
    process.predict(step, step.stamp + from_seconds(dt), false);
    for (int j = 0; j < k; ++j) {
      const Eigen::MatrixXd cross = F * joint.block(n * (k - 1), n * j, n, n);
      joint.block(n * k, n * j, n, n) = cross;
      joint.block(n * j, n * k, n, n) = cross.transpose();
    }
    joint.block(n * k, n * k, n, n) = step.P;
    means.push_back(step.mean);
  }
  const auto measured = [](int k) { return k % 4 == 1; };
  const auto z = [](int k) {
    return Eigen::Vector2d(0.2 * (k + 1) + 0.3 * std::sin(3.0 * k), 0.2 * std::cos(5.0 * k));
  };
  const double sigma = 0.3;
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(6, n * kSteps);
  Eigen::VectorXd nu = Eigen::VectorXd::Zero(6);
  for (int k = 0, row = 0; k < kSteps; ++k) {
    if (!measured(k)) continue;
    H.block(row, n * k, 2, 2).setIdentity();
    nu.segment(row, 2) = z(k) - means[static_cast<std::size_t>(k)].T_map_base.p.head<2>();
    row += 2;
  }
  const Eigen::MatrixXd S = H * joint * H.transpose() + sigma * sigma * Eigen::MatrixXd::Identity(6, 6);
  const Eigen::MatrixXd K = joint * H.transpose() * S.inverse();
  const Eigen::VectorXd delta = K * nu;
  const Eigen::MatrixXd P = joint - K * H * joint;

  estimation::Smoother smoother(process);
  Belief belief = prior;
  for (int k = 0; k < kSteps; ++k) {
    process.predict(belief, belief.stamp + from_seconds(dt), false);
    if (measured(k)) {
      Linearization model;
      estimation::ekf::Innovation innovation;
      PositionModel(z(k), sigma).linearize({belief.mean, nullptr}, model);
      test::innovate(belief, layout, -1, model, innovation);
      estimation::ekf::apply(belief, layout, innovation);
    }
    smoother.add(belief, false);
  }
  const std::vector<SmoothedPose> smoothed = smoother.smooth();
  ASSERT_EQ(smoothed.size(), static_cast<std::size_t>(kSteps));
  for (int k = 0; k < kSteps; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const Eigen::Vector2d expected = means[i].T_map_base.p.head<2>() + delta.segment(n * k, 2);
    EXPECT_LT((smoothed[i].T_map_base.p.head<2>() - expected).norm(), 1e-8) << k;
    EXPECT_LT((smoothed[i].P.topLeftCorner<2, 2>() - P.block(n * k, n * k, 2, 2)).norm(), 1e-8) << k;
  }
}

}  // namespace
}  // namespace waymark
