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

/// True if it noticed something in so many steps, of which every `expected`-th is expected and every `forth`-th jumps
/// to the other side.
bool notices(int steps, int expected, int forth) {
  JumpWatch watch;
  bool is_noticed = false;
  for (int k = 1; k <= steps; ++k) {
    if (k % expected == 0) {
      watch.add(Eigen::Vector3d::Zero());
    } else {
      watch.add(k % forth == 0 ? Eigen::Vector3d(-kBack) : kBack);
    }
    is_noticed = is_noticed || watch.is_one_sided();
  }
  return is_noticed;
}

TEST(JumpWatch, NoticesMatchesThatPullTheRobotBackManyTimesInARow) {
  constexpr int kNever = 1000;
  EXPECT_TRUE(notices(100, kNever, kNever));
  EXPECT_TRUE(notices(100, 10, kNever));
  EXPECT_FALSE(notices(6, kNever, kNever)) << "too few";
  EXPECT_FALSE(notices(100, 7, kNever)) << "matches in between fit where the motion expects them";
  EXPECT_FALSE(notices(100, kNever, 7)) << "noise that is too small has two sides";
  EXPECT_FALSE(JumpWatch{}.is_one_sided());
}

/// A filter that stands, in a map that has it 0.1 m farther to one side, or to either, at every step.
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
