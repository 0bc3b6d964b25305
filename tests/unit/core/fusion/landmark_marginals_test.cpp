// SPDX-License-Identifier: Apache-2.0
#include "fusion/landmark_marginals.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <vector>

namespace waymark::fusion {
namespace {

class LandmarkMarginals : public testing::Test {
 protected:
  void add(double x, std::optional<joint::JointBelief::LandmarkEstimate> estimate) {
    LandmarkView& landmark = landmarks_.emplace_back();
    landmark.p_map = {x, 0.0};
    landmark.P = 0.01 * Eigen::Matrix3d::Identity();
    marginal_.push_back(std::move(estimate));
    own_.emplace_back(0.002 * Eigen::Matrix2d::Identity());
  }
  static joint::JointBelief::LandmarkEstimate at(double x, double variance) {
    return {{x, 0.0}, variance * Eigen::Matrix2d::Identity()};
  }
  void report() { report_marginals(landmarks_, marginal_, own_); }

  std::vector<LandmarkView> landmarks_;
  std::vector<std::optional<joint::JointBelief::LandmarkEstimate>> marginal_;
  std::vector<Eigen::Matrix2d> own_;
};

TEST_F(LandmarkMarginals, ANodeGivesItsSecondMomentAboutTheReportedPlace) {
  add(0.0, at(0.3, 0.5));
  report();
  EXPECT_NEAR(landmarks_[0].P(0, 0), 0.5 + 0.09, 1e-12);
  EXPECT_NEAR(landmarks_[0].P(1, 1), 0.5, 1e-12);
  EXPECT_NEAR(landmarks_[0].P(2, 2), 0.01, 1e-12) << "of the radius";
  EXPECT_NEAR(landmarks_[0].P_conditional(0, 0), 0.01, 1e-12);
}

TEST_F(LandmarkMarginals, WithoutANodeItIsAsUncertainAsTheNearestOneThatHasOne) {
  add(0.0, at(0.0, 0.5));
  add(7.0, std::nullopt);
  add(10.0, at(10.2, 2.0));
  report();
  EXPECT_NEAR(landmarks_[1].P(0, 0), 2.0 + 0.04 + 0.002, 1e-12);
  EXPECT_NEAR(landmarks_[1].P_conditional(0, 0), 0.01, 1e-12);
}

TEST_F(LandmarkMarginals, WithoutAnyNodeTheyStayAsTheyAre) {
  add(0.0, std::nullopt);
  report();
  EXPECT_NEAR(landmarks_[0].P(0, 0), 0.01, 1e-12);
}

}  // namespace
}  // namespace waymark::fusion
