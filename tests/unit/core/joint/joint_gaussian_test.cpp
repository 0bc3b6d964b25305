// SPDX-License-Identifier: Apache-2.0
#include "joint/joint_gaussian.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <functional>
#include <sstream>
#include <vector>

#include "loops/twist.hpp"
#include "waymark/math/random.hpp"

namespace waymark::joint {
namespace {

const StateLayout& planar() {
  static const StateLayout layout(StateLayout::Motion::planar, {});
  return layout;
}

Belief at_origin() {
  Belief belief;
  belief.mean.v_base = {1.0, 0.0, 0.0};
  belief.mean.w_base = {0.0, 0.0, 0.1};
  belief.P = ErrorMatrix::Zero(6, 6);
  belief.P.diagonal() << 0.01, 0.02, 0.003, 0.1, 0.1, 0.05;
  return belief;
}

/// The same by plain matrices over all states.
struct Dense {
  Eigen::MatrixXd P;
  Eigen::VectorXd correction;  // of the nodes, since it was cleared

  void predict(const Eigen::MatrixXd& F, const Eigen::MatrixXd& own) {
    P.rightCols(P.cols() - 6).topRows(6) = (F * P.topRightCorner(6, P.cols() - 6)).eval();
    P.bottomLeftCorner(P.rows() - 6, 6) = P.topRightCorner(6, P.cols() - 6).transpose();
    P.topLeftCorner(6, 6) = own;
  }
  /// `moved`: by how much the mean's position changed, whose errors keep their meaning as motions of the map.
  void update(const Eigen::MatrixXd& H, const Eigen::MatrixXd& R, const Eigen::VectorXd& nu,
              const std::function<Eigen::Vector2d()>& moved) {
    const Eigen::MatrixXd K = P * H.transpose() * (H * P * H.transpose() + R).inverse();
    P = ((Eigen::MatrixXd::Identity(P.rows(), P.rows()) - K * H) * P).eval();
    correction = K * nu;
    const Eigen::Vector2d d = moved();
    Eigen::MatrixXd J = Eigen::MatrixXd::Identity(P.rows(), P.rows());
    J(0, 2) = -d.y();
    J(1, 2) = d.x();
    P = (J * P * J.transpose()).eval();
  }
  void add(const Eigen::MatrixXd& G, const Eigen::MatrixXd& Q) {
    const auto n = P.rows();
    const auto d = G.rows();
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(n + d, n);
    J.topRows(n).setIdentity();
    J.block(n, 0, d, 3) = G;
    P = (J * P * J.transpose()).eval();
    P.bottomRightCorner(d, d) += Q;
  }
};

/// With all nodes near, and with so little room that most are distant.
class JointGaussianTest : public testing::TestWithParam<NearLimits> {
 protected:
  JointGaussianTest() : process_(planar(), ProcessNoise{}), joint_(planar(), GetParam()) {
    joint_.start(at_origin());
    dense_.P = joint_.belief().P;
  }

  void predict(double dt) {
    const Eigen::MatrixXd F = process_.transition(joint_.belief().mean, dt);
    joint_.predict(process_, joint_.belief().stamp + from_seconds(dt), false);
    dense_.predict(F, joint_.belief().P);
  }
  void update() {
    Linearization model;
    model.reset(2, 0);
    model.R = Eigen::Matrix2d{{0.3, 0.1}, {0.1, 0.2}};
    estimation::StateJacobian H;
    H.reset(2, 6);
    H.add(0, Eigen::Vector2d(1.0, 0.2));
    H.add(2, Eigen::Vector2d(0.5, -1.0));
    H.add(4, Eigen::Vector2d(0.0, 1.0));
    model.residual = Eigen::Vector2d(0.3, -0.2);
    const Eigen::Vector2d before = position();
    joint_.update(model, H);
    Eigen::MatrixXd all = Eigen::MatrixXd::Zero(2, dense_.P.cols());
    all.col(0) << 1.0, 0.2;
    all.col(2) << 0.5, -1.0;
    all.col(4) << 0.0, 1.0;
    dense_.update(all, model.R, model.residual, [&] { return Eigen::Vector2d(position() - before); });
  }
  void add(const Eigen::MatrixXd& G, const Eigen::MatrixXd& Q) {
    offsets_.push_back(static_cast<int>(dense_.P.rows()));
    nodes_.push_back(joint_.add_node(G, Q));
    dense_.add(G, Q);
  }
  void relate(std::size_t node, const Eigen::MatrixXd& H_pose, const Eigen::MatrixXd& H_node) {
    for (const auto id : nodes_) joint_.take_correction(id);
    const Eigen::Vector2d before = position();
    const Eigen::VectorXd nu = Eigen::VectorXd::LinSpaced(H_pose.rows(), 0.1, 0.4);
    joint_.relate(nu, H_pose, {{nodes_[node], H_node}});
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(H_pose.rows(), dense_.P.cols());
    H.leftCols(3) = H_pose;
    H.middleCols(offsets_[node], H_node.cols()) = H_node;
    dense_.update(H, Eigen::MatrixXd::Identity(H.rows(), H.rows()), nu,
                  [&] { return Eigen::Vector2d(position() - before); });
    EXPECT_LT((position() - before - dense_.correction.head<2>()).norm(), 1e-10);
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const auto correction = joint_.take_correction(nodes_[i]);
      EXPECT_LT((correction - dense_.correction.segment(offsets_[i], correction.size())).norm(), 1e-10);
    }
  }
  Eigen::Vector2d position() const { return joint_.belief().mean.T_map_base.p.head<2>(); }
  void expect_equal() const {
    EXPECT_LT((joint_.belief().P - dense_.P.topLeftCorner(6, 6)).norm(), 1e-10);
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const JointGaussian::Rows P = joint_.node_covariance(nodes_[i]);
      EXPECT_LT((P - dense_.P.block(offsets_[i], offsets_[i], P.rows(), P.rows())).norm(), 1e-10) << i;
      EXPECT_LT((joint_.cross_covariance(nodes_[i]) - dense_.P.block(offsets_[i], 0, P.rows(), 6)).norm(), 1e-10) << i;
    }
  }

  estimation::ProcessModel process_;
  JointGaussian joint_;
  Dense dense_;
  std::vector<JointGaussian::NodeId> nodes_;
  std::vector<int> offsets_;
};

TEST_P(JointGaussianTest, EqualsTheSameComputedByPlainMatrices) {
  Random random({7, 0, 0, 0});
  const auto rows = [&](int r, int c) {
    return Eigen::MatrixXd::NullaryExpr(r, c, [&] { return random.normal(); }).eval();
  };
  for (int step = 0; step < 40; ++step) {
    predict(0.1);
    if (step % 3 == 0) update();
    if (step % 10 == 0) add(rows(2, 3), 0.1 * Eigen::Matrix2d::Identity());
    if (step % 10 == 5) add(rows(3, 3), 0.2 * Eigen::Matrix3d::Identity());
    const auto node = static_cast<std::size_t>(step) % nodes_.size();
    const auto size = joint_.node_covariance(nodes_[node]).rows();
    relate(node, 3.0 * rows(3, 3), 3.0 * rows(3, static_cast<int>(size)));
    expect_equal();
    EXPECT_LE(joint_.near_size(), GetParam().most);
  }
  EXPECT_EQ(joint_.size(), 20);
}

TEST_P(JointGaussianTest, ARemovedNodeIsMarginalised) {
  for (int i = 0; i < 4; ++i) {
    predict(0.5);
    add(Eigen::Matrix3d::Identity(), 0.01 * Eigen::Matrix3d::Identity());
    relate(static_cast<std::size_t>(i) / 2, 5.0 * Eigen::Matrix3d::Identity(), -5.0 * Eigen::Matrix3d::Identity());
  }
  joint_.remove_node(nodes_[1]);
  EXPECT_FALSE(joint_.has_node(nodes_[1]));
  nodes_.erase(nodes_.begin() + 1);
  offsets_.erase(offsets_.begin() + 1);
  expect_equal();
}

/// The mean of the robot jumps about, as wrong fixes would have it: its heading relative to the anchor is measured all
/// the time, but where the two look together is not known better for that.
TEST_P(JointGaussianTest, JumpsOfTheMeanGiveNoInformationAboutTheHeadingOfTheMap) {
  const auto anchor = joint_.add_node(loops::twist_of_error(position()), 1e-4 * Eigen::Matrix3d::Identity());
  const double before = joint_.node_covariance(anchor)(2, 2);
  Random random({3, 0, 0, 0});
  for (int i = 0; i < 200; ++i) {
    const Eigen::Matrix3d precise = 100.0 * Eigen::Matrix3d::Identity();
    const Eigen::Vector3d nu(100.0 * random.normal(), 100.0 * random.normal(), 0.0);
    joint_.relate(nu, precise, {{anchor, -precise * loops::error_of_twist(position())}});
    joint_.predict(process_, joint_.belief().stamp + from_seconds(0.2), false);
  }
  EXPECT_GT(joint_.node_covariance(anchor)(2, 2), 0.95 * before);
  EXPECT_GT(joint_.belief().P(2, 2), 0.95 * 0.003);
}

TEST_P(JointGaussianTest, ANewStartIsCorrelatedWithNoNode) {
  for (int i = 0; i < 4; ++i) {
    predict(0.5);
    add(Eigen::Matrix3d::Identity(), 0.01 * Eigen::Matrix3d::Identity());
    relate(static_cast<std::size_t>(i), Eigen::Matrix3d::Identity(), -Eigen::Matrix3d::Identity());
  }
  joint_.restart(at_origin());
  dense_.P.topRows(6).setZero();
  dense_.P.leftCols(6).setZero();
  dense_.P.topLeftCorner(6, 6) = at_origin().P;
  expect_equal();
  relate(0, Eigen::Matrix3d::Identity(), -Eigen::Matrix3d::Identity());
  expect_equal();
}

TEST_P(JointGaussianTest, ANewStartWithNodesHasTheCovarianceThatItIsGiven) {
  for (int i = 0; i < 6; ++i) {
    predict(0.5);
    add(Eigen::Matrix3d::Identity(), 0.01 * Eigen::Matrix3d::Identity());
  }
  relate(1, Eigen::Matrix3d::Identity(), -Eigen::Matrix3d::Identity());
  Random random({5, 0, 0, 0});
  const std::vector<JointGaussian::NodeId> kept{nodes_[0], nodes_[2], nodes_[3], nodes_[5]};
  // Of the pose and the four nodes.
  const Eigen::MatrixXd root = Eigen::MatrixXd::NullaryExpr(15, 15, [&] { return random.normal(); });
  const Eigen::MatrixXd P = root * root.transpose();
  Belief belief = at_origin();
  belief.stamp = joint_.belief().stamp;
  belief.P.topLeftCorner(3, 3) = P.topLeftCorner(3, 3);
  joint_.restart(belief, kept, P.bottomLeftCorner(12, 3), P.bottomRightCorner(12, 12));
  EXPECT_FALSE(joint_.has_node(nodes_[1]));
  dense_.P.setZero(18, 18);
  dense_.P.topLeftCorner(6, 6) = belief.P;
  dense_.P.bottomLeftCorner(12, 3) = P.bottomLeftCorner(12, 3);
  dense_.P.topRightCorner(3, 12) = P.topRightCorner(3, 12);
  dense_.P.bottomRightCorner(12, 12) = P.bottomRightCorner(12, 12);
  nodes_ = kept;
  offsets_ = {6, 9, 12, 15};
  expect_equal();
  relate(2, 2.0 * Eigen::Matrix3d::Identity(), -2.0 * Eigen::Matrix3d::Identity());
  predict(0.2);
  expect_equal();
}

TEST_P(JointGaussianTest, ItsCheckpointIsTheSame) {
  for (int i = 0; i < 3; ++i) {
    predict(0.3);
    add(Eigen::Matrix3d::Identity(), 0.01 * Eigen::Matrix3d::Identity());
    relate(0, Eigen::Matrix3d::Identity(), -Eigen::Matrix3d::Identity());
  }
  std::stringstream stream;
  OutArchive out(stream);
  out(joint_);
  JointGaussian loaded(planar(), GetParam());
  InArchive in(stream);
  in(loaded);
  for (JointGaussian* one : {&joint_, &loaded}) {
    one->predict(process_, one->belief().stamp + from_seconds(0.2), false);
    one->relate(Eigen::Vector3d(0.1, 0.2, 0.3), Eigen::Matrix3d::Identity(),
                {{nodes_[2], -Eigen::Matrix3d::Identity()}});
  }
  EXPECT_EQ(loaded.belief().P, joint_.belief().P);
  EXPECT_EQ(loaded.belief().mean.T_map_base.p, joint_.belief().mean.T_map_base.p);
  for (const auto node : nodes_) EXPECT_EQ(loaded.node_covariance(node), joint_.node_covariance(node));
}

INSTANTIATE_TEST_SUITE_P(Limits, JointGaussianTest, testing::Values(NearLimits{}, NearLimits{.most = 9, .kept = 6}),
                         [](const auto& tested) { return tested.param.most == 9 ? "most_distant" : "all_near"; });

}  // namespace
}  // namespace waymark::joint
