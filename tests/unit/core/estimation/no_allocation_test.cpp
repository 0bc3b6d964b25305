// SPDX-License-Identifier: Apache-2.0
// Predict, update, gate and weight do not touch the heap once warm: here every allocation of the process is counted.
#include <gtest/gtest.h>

#include "unit/core/particle_run.hpp"
#include "unit/counted_memory.hpp"

namespace waymark {
namespace {

using counted::allocations;
using namespace test;  // NOLINT(google-build-using-namespace): the robot's parts

class NoAllocation : public ::testing::TestWithParam<int> {};

TEST_P(NoAllocation, PredictUpdateGateAndWeight) {
  ParticleFilterSettings settings;
  settings.particles = GetParam();
  settings.resample_threshold = 0.0;
  ParticleRun run(settings);
  run.filter().start(run.prior(), true);
  const TwistModel twist({1.0, 0.0, 0.0}, {0.1, 0.1, 0.1});
  const PositionModel far({1e6, 0.0}, 0.1);
  const particles::UpdatePolicy policy;
  const auto step = [&](int k) {
    run.filter().predict(at(0.01 * (k + 1)), false);
    run.filter().update(twist, policy);
    const PositionModel near({0.01 * k, 0.0}, 0.3);
    run.filter().update(near, policy);
    EXPECT_FALSE(run.filter().update(far, policy).accepted);
    run.filter().mixture();
  };
  for (int k = 0; k < 10; ++k) step(k);
  const long before = allocations;
  for (int k = 10; k < 110; ++k) step(k);
  EXPECT_EQ(allocations - before, 0);
}

INSTANTIATE_TEST_SUITE_P(Particles, NoAllocation, ::testing::Values(1, 25));

TEST(Allocations, AreCounted) {
  const long before = allocations;
  auto* kept = new std::vector<int>(100);
  EXPECT_GE(allocations - before, 2);
  delete kept;
}

}  // namespace
}  // namespace waymark
