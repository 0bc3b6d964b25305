// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "unit/core/opinion_map.hpp"
#include "unit/core/particle_run.hpp"

namespace waymark {
namespace {

using test::kOpinionSigma;
using test::Opinion;
using test::OpinionModule;

constexpr double kMissedTurn = 0.9;  // [rad]
const Eigen::Vector3d kSlip = Eigen::Vector3d(0.3, 0.3, 0.9).cwiseAbs2();

/// A filter that stands still with a σ of 1 mm and 1 mrad, and whose maps then find it turned by `kMissedTurn`.
class TurnedFilter {
 public:
  TurnedFilter(const Eigen::Vector3d& slip, bool joint) : run_(settings(joint), {map_}) {
    Belief prior = run_.prior();
    prior.P.diagonal().setConstant(kOpinionSigma * kOpinionSigma);
    run_.filter().start(prior, false);
    see();
    map_->change({{{0.0, 0.0, kMissedTurn}, 0.0, slip}});
    see();
  }

  particles::ParticleFilter& filter() { return run_.filter(); }
  double yaw() { return filter().reported().mean.T_map_base.yaw(); }
  double yaw_sigma() { return std::sqrt(pose_covariance(filter().reported(), run_.layout())(2, 2)); }

 private:
  void see() {
    const test::Sighting sighting;
    const std::vector<particles::MappingInput> inputs{{0, &sighting, 1.0, true}};
    EXPECT_TRUE(run_.filter().map(inputs, 0).empty());
  }
  static ParticleFilterSettings settings(bool joint) {
    ParticleFilterSettings s;
    s.particles = 4;
    s.sampling_fraction = 0.0;
    s.joint.enabled = joint;
    return s;
  }
  std::shared_ptr<OpinionModule> map_ = std::make_shared<OpinionModule>(std::vector<Opinion>{{{0.0, 0.0, 0.0}}});
  test::ParticleRun run_;
};

TEST(Slip, APriorThatMissedATurnDoesNotHoldTheMatchBack) {
  TurnedFilter slipped(kSlip, false);
  EXPECT_NEAR(slipped.yaw(), kMissedTurn, 1e-5);
  EXPECT_NEAR(slipped.yaw_sigma(), kOpinionSigma, 1e-5);
  EXPECT_LT(slipped.filter().map_innovation().nis, 1.1) << "it is as wide as the slip";

  TurnedFilter not_slipped(Eigen::Vector3d::Zero(), false);
  EXPECT_NEAR(not_slipped.yaw(), kMissedTurn / 3.0, 1e-3) << "a third of what is known is this match";
  EXPECT_GT(not_slipped.filter().map_innovation().nis, 1e4);
}

TEST(Slip, TheJointGaussianSlipsWithTheBestParticle) {
  TurnedFilter slipped(kSlip, true);
  EXPECT_NEAR(slipped.yaw(), kMissedTurn, 1e-5);
  EXPECT_LT(slipped.yaw_sigma(), 0.05) << "its mean lies where the particles are";
}

}  // namespace
}  // namespace waymark
