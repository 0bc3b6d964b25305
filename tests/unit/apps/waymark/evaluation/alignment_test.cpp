// SPDX-License-Identifier: Apache-2.0
#include "apps/waymark/evaluation/alignment.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "waymark/base/error.hpp"

namespace waymark::evaluation {
namespace {

TEST(FitSe2, FindsAQuarterTurnByHand) {
  const std::vector<Eigen::Vector2d> from{{0, 0}, {2, 0}, {2, 1}};
  const std::vector<Eigen::Vector2d> to{{5, 1}, {5, 3}, {4, 3}};
  const Pose T = fit_se2(from, to);
  EXPECT_NEAR(T.yaw(), 0.5 * std::numbers::pi, 1e-12);
  EXPECT_NEAR(T.p.x(), 5.0, 1e-12);
  EXPECT_NEAR(T.p.y(), 1.0, 1e-12);
}

// Four points of a unit cross, moved outwards by different lengths along their own axes: the rotation is determined by
// tan(yaw) = Σ cross / Σ dot = 0 and the shift by the means, (0.5, 0.25).
TEST(FitSe2, BalancesDeviationsByHand) {
  const std::vector<Eigen::Vector2d> from{{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
  const std::vector<Eigen::Vector2d> to{{3, 0}, {-1, 0}, {0, 2}, {0, -1}};
  const Pose T = fit_se2(from, to);
  EXPECT_NEAR(T.yaw(), 0.0, 1e-12);
  EXPECT_NEAR(T.p.x(), 0.5, 1e-12);
  EXPECT_NEAR(T.p.y(), 0.25, 1e-12);
}

TEST(FitSe2, RefusesPointsThatSettleNoRotation) {
  const std::vector<Eigen::Vector2d> one{{1, 2}};
  const std::vector<Eigen::Vector2d> same{{1, 2}, {1, 2}};
  const std::vector<Eigen::Vector2d> apart{{1, 2}, {3, 2}};
  EXPECT_THROW(fit_se2(one, one), Error);
  EXPECT_THROW(fit_se2(same, same), Error);
  EXPECT_THROW(fit_se2(same, apart), Error);
}

TEST(FitSe3, RecoversARigidMotion) {
  const Pose truth{so3::from_rpy(0.4, -0.7, 2.5), {1, -2, 3}};
  const std::vector<Eigen::Vector3d> from{{0, 0, 0}, {4, 0, 1}, {1, 3, 0}, {-2, 1, 5}};
  std::vector<Eigen::Vector3d> to;
  for (const auto& p : from) to.emplace_back(truth * p);
  const Pose T = fit_se3(from, to);
  EXPECT_LT(so3::log(T.q.conjugate() * truth.q).norm(), 1e-12);
  EXPECT_LT((T.p - truth.p).norm(), 1e-12);
}

TEST(FitSe3, NeverReflects) {
  const std::vector<Eigen::Vector3d> from{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}};
  std::vector<Eigen::Vector3d> to;
  for (const auto& p : from) to.emplace_back(p.x(), p.y(), -p.z());
  EXPECT_NEAR(fit_se3(from, to).q.toRotationMatrix().determinant(), 1.0, 1e-12);
}

TEST(FitSe3, AcceptsAPlaneButNoLine) {
  const std::vector<Eigen::Vector3d> plane{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const std::vector<Eigen::Vector3d> line{{0, 0, 0}, {1, 1, 1}, {3, 3, 3}};
  EXPECT_LT(so3::log(fit_se3(plane, plane).q).norm(), 1e-12);
  EXPECT_THROW(fit_se3(line, line), Error);
}

}  // namespace
}  // namespace waymark::evaluation
