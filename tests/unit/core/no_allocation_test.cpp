// SPDX-License-Identifier: Apache-2.0
// Predict, update, gate and weight do not touch the heap once warm: here every allocation of the process is counted.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "unit/core/particle_run.hpp"

namespace {
std::atomic<long> allocations{0};
}  // namespace

// NOLINTBEGIN: these are the global operators; inlined, GCC sees malloc behind new and delete and finds them mismatched
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t alignment) {
  ++allocations;
  const auto a = static_cast<std::size_t>(alignment);
  if (void* memory = std::aligned_alloc(a, (size + a - 1) / a * a)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
// NOLINTEND

namespace waymark {
namespace {

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
  const UpdatePolicy policy;
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
