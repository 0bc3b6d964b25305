// SPDX-License-Identifier: Apache-2.0
#include "particles/mapping_step.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "unit/core/opinion_map.hpp"
#include "unit/core/toy_map.hpp"

namespace waymark {
namespace {

using particles::MappingStep;
using test::OpinionModule;

const StateLayout& planar() {
  static const StateLayout layout(StateLayout::Motion::planar, {});
  return layout;
}

/// The particles now, and nothing that they do.
class Now final : public particles::Instant {
 public:
  explicit Now(particles::ParticleSet& set) : set_(set) {}
  Belief& belief(std::size_t slot) override { return set_[slot].belief; }
  const Belief& mixture() override { return set_[0].belief; }
  void carry_gain(std::size_t, const estimation::StateJacobian&, estimation::ekf::Innovation&) override {}
  void sample(std::uint32_t) override {}
  void conclude_mapping(std::uint32_t) override {}

 private:
  particles::ParticleSet& set_;
};

/// Two particles at the origin with a σ of 0.1 m and 0.1 rad. The map finds the first one 1 m ahead, which is not
/// expected, and slipped; the second one where it is.
class Jump : public testing::Test {
 protected:
  static constexpr double kWith = -2.0;
  static constexpr double kWithout = -30.0;

  void refine(particles::MayJump may_jump) {
    MappingStep step(planar(), workers_, {}, 2, std::move(may_jump));
    OpinionModule module(
        {{{1.0, 0.0, 0.0}, kWith, Eigen::Vector3d::Constant(0.09), kWithout}, {{0.0, 0.0, 0.0}, kWith}});
    for (particles::Particle& particle : set_) {
      particle.belief.P = 0.01 * ErrorMatrix::Identity(planar().size(), planar().size());
      particle.maps.push_back(module.create_map());
    }
    Now now(set_);
    const test::Sighting sighting;
    const std::vector<particles::MappingInput> inputs{{0, &sighting, 1.0, true}};
    particles::MappingFailures failures;
    step.refine(set_, now, inputs, Time{}, 0, failures, [](int) {});
    ASSERT_TRUE(failures.empty());
    failed_ = step.refinement(0, 0).failed;
  }
  double x(std::size_t slot) { return set_[slot].belief.mean.T_map_base.p.x(); }
  double sigma(std::size_t slot) { return std::sqrt(set_[slot].belief.P(0, 0)); }
  double log_weight(std::size_t slot) { return set_[slot].log_weight; }
  bool failed() const { return failed_; }

 private:
  particles::Workers workers_{1};
  particles::ParticleSet set_{2};
  bool failed_ = false;
};

TEST_F(Jump, IsUsedWhereItMayBe) {
  Pose asked_at;
  refine([&](const auto&, const Pose& pose) {
    asked_at = pose;
    return true;
  });
  EXPECT_NEAR(asked_at.p.x(), 1.0, 1e-12);
  EXPECT_NEAR(x(0), 1.0, 1e-4);
  EXPECT_FALSE(failed());
  EXPECT_DOUBLE_EQ(log_weight(0), log_weight(1));
}

TEST_F(Jump, ThatIsRefusedLeavesThePriorAndTheEvidenceOfNoMatch) {
  refine([](const auto&, const Pose&) { return false; });
  EXPECT_EQ(x(0), 0.0);
  EXPECT_DOUBLE_EQ(sigma(0), 0.1) << "nor has it slipped";
  EXPECT_TRUE(failed());
  EXPECT_DOUBLE_EQ(log_weight(0) - log_weight(1), kWithout - kWith);
  EXPECT_NEAR(sigma(1), test::kOpinionSigma, 1e-4) << "the other match is expected";
}

}  // namespace
}  // namespace waymark
