// SPDX-License-Identifier: Apache-2.0
#include "particles/jump_watch.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "unit/core/opinion_map.hpp"
#include "unit/core/particle_run.hpp"

namespace waymark {
namespace {

using particles::JumpWatch;
using test::kOpinionSigma;
using test::Opinion;
using test::OpinionModule;

const Eigen::Vector3d kBack(-9.0, 0.5, 0.0);

JumpWatch watched(int steps, int jumping_of_ten, int back_of_ten) {
  JumpWatch watch;
  for (int k = 0; k < steps; ++k) {
    const bool jumps = k % 10 < jumping_of_ten;
    const double side = k % 10 < back_of_ten ? 1.0 : -1.0;
    watch.add(jumps ? Eigen::Vector3d(side * kBack) : Eigen::Vector3d::Zero());
  }
  return watch;
}

TEST(JumpWatch, NoticesMatchesThatAlwaysPullTheRobotBack) {
  EXPECT_TRUE(watched(100, 10, 10).is_one_sided());
  EXPECT_TRUE(watched(100, 8, 8).is_one_sided());
  EXPECT_FALSE(watched(15, 10, 10).is_one_sided()) << "too few";
  EXPECT_FALSE(watched(100, 3, 3).is_one_sided()) << "most fit where the motion expects them";
  EXPECT_FALSE(watched(100, 10, 9).is_one_sided()) << "noise that is too small has two sides";
  EXPECT_FALSE(JumpWatch{}.is_one_sided());
}

/// A filter that stands, in a map that has it 1 cm farther to one side, or to either, at every step.
class PulledFilter {
 public:
  PulledFilter() : run_(settings(), {map_}) {
    Belief prior = run_.prior();
    prior.P.diagonal().setConstant(kOpinionSigma * kOpinionSigma);
    run_.filter().start(prior, false);
  }
  void pull(int steps, bool to_one_side) {
    for (int k = 0; k < steps; ++k) {
      x_ += to_one_side || k % 2 == 0 ? -0.1 : 0.1;
      map_->change({{{x_, 0.0, 0.0}, 0.0, Eigen::Vector3d::Zero(), -1.0}});
      const test::Sighting sighting;
      const std::vector<particles::MappingInput> inputs{{0, &sighting, 1.0, true}};
      EXPECT_TRUE(run_.filter().map(inputs, 0).empty());
    }
  }
  particles::ParticleFilter& filter() { return run_.filter(); }

 private:
  static ParticleFilterSettings settings() {
    ParticleFilterSettings s;
    s.particles = 4;
    s.joint.enabled = false;
    return s;
  }
  double x_ = 0.0;
  std::shared_ptr<OpinionModule> map_ = std::make_shared<OpinionModule>(std::vector<Opinion>{{{0.0, 0.0, 0.0}}});
  test::ParticleRun run_;
};

TEST(JumpWatch, ARobotThatItsMapHoldsBackMayHaveTornIt) {
  PulledFilter pulled;
  pulled.pull(40, true);
  EXPECT_GT(pulled.filter().suspected_tears(), 2U);

  PulledFilter shaken;
  shaken.pull(40, false);
  EXPECT_EQ(shaken.filter().suspected_tears(), 0U);
}

}  // namespace
}  // namespace waymark
