// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "unit/core/particle_run.hpp"

namespace waymark {
namespace {

// 64 particles are above the size below which the host does not wake its threads.
std::string bytes_with(int threads, std::uint64_t seed = 1) {
  ParticleFilterSettings settings;
  settings.particles = 64;
  settings.threads = threads;
  settings.seed = seed;
  settings.sampling_fraction = 0.5;
  test::ParticleRun run(settings, {std::make_shared<test::ToyModule>(), std::make_shared<test::ToyModule>()});
  run.filter().start(run.prior(), true);
  run.drive(0, 25);
  EXPECT_GT(run.filter().resamplings(), 0U);
  return run.bytes();
}

TEST(ParticleFilterThreads, TheNumberOfThreadsDoesNotChangeAByte) {
  const std::string one = bytes_with(1);
  EXPECT_EQ(bytes_with(1), one);
  EXPECT_EQ(bytes_with(2), one);
  EXPECT_EQ(bytes_with(4), one);
}

TEST(ParticleFilterThreads, TheSeedDoes) { EXPECT_NE(bytes_with(2, 2), bytes_with(2, 1)); }

TEST(ParticleFilterThreads, AModuleThatThrowsInOneThreadIsDroppedTheSameWay) {
  const auto run_with = [](int threads) {
    ParticleFilterSettings settings;
    settings.particles = 64;
    settings.threads = threads;
    test::ParticleRun run(settings, {std::make_shared<test::ToyModule>(test::ToyMap::Fails::in_refine, 40),
                                     std::make_shared<test::ToyModule>()});
    run.filter().start(run.prior(), true);
    run.drive(0, 5);
    EXPECT_EQ(run.filter().particles()[0].maps[0], nullptr);
    return run.bytes();
  };
  EXPECT_EQ(run_with(4), run_with(1));
}

}  // namespace
}  // namespace waymark
