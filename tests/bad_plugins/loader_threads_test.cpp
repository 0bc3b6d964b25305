// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

#include "waymark/interface/sensor.hpp"
#include "waymark/plugin_loader.hpp"

namespace waymark {
namespace {

TEST(LoaderThreads, SamePluginIsBuiltFromManyThreadsAtOnce) {
  constexpr int kThreads = 4;
  std::atomic<int> built = 0;
  std::vector<std::thread> threads;
  for (int i = 0; i < kThreads; ++i) {
    threads.emplace_back([&built] {
      const Config config = Config::parse("sigma_mps: 0.5\n");
      const PluginLoader loader({WAYMARK_BAD_PLUGIN_DIR});
      for (int k = 0; k < 20; ++k) {
        const auto sensor = loader.create<Sensor>("throws_at_1000", config, Rig({}));
        if (sensor->clone() != nullptr) ++built;
      }
      EXPECT_FALSE(loader.list().empty());
    });
  }
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(built, kThreads * 20);
}

}  // namespace
}  // namespace waymark
